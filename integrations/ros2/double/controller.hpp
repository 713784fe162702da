// The part of controller_interface's base class that a controller sees, the same in every release, plus the manager's
// actions on it: transitions, and lending and withdrawing interfaces. Include it after the handles of a release.
// SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef DOUBLE_CONTROLLER_HPP
#define DOUBLE_CONTROLLER_HPP

#include "rclcpp/logging.hpp"

namespace controller_interface {

using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

enum class return_type : std::uint8_t { OK = 0, ERROR = 1 };

enum class interface_configuration_type : std::uint8_t { ALL = 0, INDIVIDUAL = 1, NONE = 2 };

struct InterfaceConfiguration {
    interface_configuration_type type;
    std::vector<std::string> names = {};
};

class ControllerInterfaceBase : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface {
public:
    virtual InterfaceConfiguration command_interface_configuration() const = 0;
    virtual InterfaceConfiguration state_interface_configuration() const = 0;
    virtual CallbackReturn on_init() = 0;
    virtual return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;
    bool set_chained_mode(bool chained_mode) {
        bool done = life != Life::ACTIVE && on_set_chained_mode(chained_mode);
        in_chained_mode_ = done ? chained_mode : in_chained_mode_;
        return done;
    }
    bool is_in_chained_mode() const { return in_chained_mode_; }

    void assign_interfaces(std::vector<hardware_interface::LoanedCommandInterface> &&commands,
                           std::vector<hardware_interface::LoanedStateInterface> &&states) {
        command_interfaces_ = std::move(commands);
        state_interfaces_ = std::move(states);
    }
    void release_interfaces() {
        command_interfaces_.clear();
        state_interfaces_.clear();
    }
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return node_; }
    unsigned int get_update_rate() const { return update_rate_; }

    template <class T>
    auto auto_declare(const std::string &name, const T &value) {
        return get_node()->has_parameter(name) ? get_node()->get_parameter(name).get_value<T>()
                                               : get_node()->declare_parameter<T>(name, value);
    }

    // The manager's side, with fewer states than the original.
    enum class Life { UNCONFIGURED, INACTIVE, ACTIVE };
    CallbackReturn init(const std::string &name, std::map<std::string, rclcpp::ParameterValue> given) {
        node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>(name);
        node_->given = std::move(given);
        return on_init();
    }
    bool configure(unsigned int update_rate) {
        update_rate_ = update_rate;
        bool done = life == Life::UNCONFIGURED && on_configure({1, "unconfigured"}) == CallbackReturn::SUCCESS;
        life = done ? Life::INACTIVE : life;
        return done;
    }
    bool activate() {
        bool done = life == Life::INACTIVE && on_activate({2, "inactive"}) == CallbackReturn::SUCCESS;
        life = done ? Life::ACTIVE : life;
        return done;
    }
    bool deactivate() {
        bool done = life == Life::ACTIVE && on_deactivate({3, "active"}) == CallbackReturn::SUCCESS;
        life = done ? Life::INACTIVE : life;
        release_interfaces();
        return done;
    }
    Life life = Life::UNCONFIGURED;

protected:
    virtual bool on_set_chained_mode(bool) { return true; }

    std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
    std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;

private:
    bool in_chained_mode_ = false;
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_;
    unsigned int update_rate_ = 0;
};

}  // namespace controller_interface

#endif
