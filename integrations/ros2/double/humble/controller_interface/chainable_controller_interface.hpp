// ros2_control of Humble, 2.54.0: handles without locks, references that point into `reference_interfaces_`, and
// `update_reference_from_subscribers` without arguments. SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef DOUBLE_CHAINABLE_CONTROLLER_INTERFACE_HPP
#define DOUBLE_CHAINABLE_CONTROLLER_INTERFACE_HPP

#include <string>
#include <utility>
#include <vector>

namespace hardware_interface {

class ReadOnlyHandle {
public:
    ReadOnlyHandle(const std::string &prefix, const std::string &name, double *value = nullptr)
        : prefix_name_(prefix), interface_name_(name), value_ptr_(value) {}
    const std::string get_name() const { return prefix_name_ + "/" + interface_name_; }
    const std::string &get_prefix_name() const { return prefix_name_; }
    const std::string &get_interface_name() const { return interface_name_; }
    double get_value() const { return *value_ptr_; }

protected:
    std::string prefix_name_, interface_name_;
    double *value_ptr_;
};

class ReadWriteHandle : public ReadOnlyHandle {
public:
    using ReadOnlyHandle::ReadOnlyHandle;
    void set_value(double value) { *value_ptr_ = value; }
};

class StateInterface : public ReadOnlyHandle {
public:
    using ReadOnlyHandle::ReadOnlyHandle;
};

class CommandInterface : public ReadWriteHandle {
public:
    using ReadWriteHandle::ReadWriteHandle;
    CommandInterface(const CommandInterface &) = delete;
    CommandInterface(CommandInterface &&) = default;
};

template <class Interface>
class Loaned {
public:
    explicit Loaned(Interface &interface) : interface_(&interface) {}
    Loaned(const Loaned &) = delete;
    Loaned(Loaned &&) = default;
    Loaned &operator=(Loaned &&) = default;
    const std::string get_name() const { return interface_->get_name(); }
    double get_value() const { return interface_->get_value(); }

protected:
    Interface *interface_;
};

class LoanedStateInterface : public Loaned<StateInterface> {
public:
    using Loaned::Loaned;
};

class LoanedCommandInterface : public Loaned<CommandInterface> {
public:
    using Loaned::Loaned;
    void set_value(double value) { interface_->set_value(value); }
};

}  // namespace hardware_interface

#include "../../controller.hpp"

namespace controller_interface {

class ChainableControllerInterface : public ControllerInterfaceBase {
public:
    return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) final {
        if (!is_in_chained_mode()) {
            return_type done = update_reference_from_subscribers();
            if (done != return_type::OK) {
                return done;
            }
        }
        return update_and_write_commands(time, period);
    }
    std::vector<hardware_interface::CommandInterface> export_reference_interfaces() {
        auto references = on_export_reference_interfaces();
        bool fits = references.size() == reference_interfaces_.size();
        for (const auto &reference : references) {
            fits = fits && reference.get_prefix_name() == get_node()->get_name();
        }
        if (!fits) {
            references.clear();
        }
        return references;
    }

protected:
    virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() = 0;
    virtual return_type update_reference_from_subscribers() = 0;
    virtual return_type update_and_write_commands(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;

    std::vector<double> reference_interfaces_;
};

}  // namespace controller_interface

#endif
