// ros2_control of Jazzy, 4.46.0, whose names and signatures equal those of Kilted 5.16.0 and Rolling 6.8.0: another
// thread may hold a handle, and values may be missing. With DOUBLE_MINOR below 44 it is an earlier release, without
// `on_export_reference_interfaces_list`. SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef DOUBLE_CHAINABLE_CONTROLLER_INTERFACE_HPP
#define DOUBLE_CHAINABLE_CONTROLLER_INTERFACE_HPP

#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "controller_interface/version.h"

namespace hardware_interface {

class Handle {
public:
    [[deprecated("Use InterfaceDescription for initializing the Interface")]] Handle(const std::string &prefix,
                                                                                      const std::string &name, double *value)
        : prefix_name_(prefix), interface_name_(name), handle_name_(prefix + "/" + name), value_ptr_(value) {}
    explicit Handle(const std::string &prefix, const std::string &name, const std::string &data_type = "double",
                    const std::string &initial_value = "")
        : prefix_name_(prefix), interface_name_(name), handle_name_(prefix + "/" + name), value_ptr_(&value_) {
        if (data_type != "double" || !initial_value.empty()) {
            throw std::invalid_argument("the double knows numbers without a first value");
        }
    }
    Handle(Handle &&other)
        : held(other.held), prefix_name_(other.prefix_name_), interface_name_(other.interface_name_),
          handle_name_(other.handle_name_), value_(other.value_),
          value_ptr_(other.value_ptr_ == &other.value_ ? &value_ : other.value_ptr_) {}
    virtual ~Handle() = default;
    const std::string &get_name() const { return handle_name_; }
    const std::string &get_prefix_name() const { return prefix_name_; }
    const std::string &get_interface_name() const { return interface_name_; }
    template <class T = double>
    [[nodiscard]] std::optional<T> get_optional() const {
        return held ? std::nullopt : std::optional<T>(*value_ptr_);
    }
    template <class T>
    [[nodiscard]] bool set_value(const T &value) {
        if (!held) {
            *value_ptr_ = value;
        }
        return !held;
    }

    bool held = false;  // by another thread

private:
    std::string prefix_name_, interface_name_, handle_name_;
    double value_ = std::numeric_limits<double>::quiet_NaN();
    double *value_ptr_;
};

class StateInterface : public Handle {
public:
    using Handle::Handle;
    using SharedPtr = std::shared_ptr<StateInterface>;
    using ConstSharedPtr = std::shared_ptr<const StateInterface>;
};

class CommandInterface : public Handle {
public:
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
    using Handle::Handle;
#pragma GCC diagnostic pop
    using SharedPtr = std::shared_ptr<CommandInterface>;
    CommandInterface(const CommandInterface &) = delete;
    CommandInterface(CommandInterface &&) = default;
};

template <class Pointer>
class Loaned {
public:
    explicit Loaned(Pointer interface) : interface_(std::move(interface)) {}
    Loaned(const Loaned &) = delete;
    Loaned(Loaned &&) = default;
    Loaned &operator=(Loaned &&) = default;
    const std::string &get_name() const { return interface_->get_name(); }
    template <class T = double>
    [[nodiscard]] std::optional<T> get_optional(unsigned int = 10) const {
        return interface_->template get_optional<T>();
    }

protected:
    Pointer interface_;
};

class LoanedStateInterface : public Loaned<StateInterface::ConstSharedPtr> {
public:
    using Loaned::Loaned;
};

class LoanedCommandInterface : public Loaned<CommandInterface::SharedPtr> {
public:
    using Loaned::Loaned;
    template <class T>
    [[nodiscard]] bool set_value(const T &value, unsigned int = 10) {
        return interface_->set_value(value);
    }
};

}  // namespace hardware_interface

#include "../../controller.hpp"

namespace controller_interface {

class ChainableControllerInterface : public ControllerInterfaceBase {
public:
    return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) final {
        if (!is_in_chained_mode()) {
            return_type done = update_reference_from_subscribers(time, period);
            if (done != return_type::OK) {
                return done;
            }
        }
        return update_and_write_commands(time, period);
    }
    std::vector<hardware_interface::CommandInterface::SharedPtr> export_reference_interfaces() {
        std::vector<hardware_interface::CommandInterface::SharedPtr> references;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
        auto pointing = on_export_reference_interfaces();
#pragma GCC diagnostic pop
        if (pointing.size() != reference_interfaces_.size()) {
            throw std::runtime_error("reference_interfaces_ has another size");
        }
        for (auto &reference : pointing) {
            references.push_back(std::make_shared<hardware_interface::CommandInterface>(std::move(reference)));
        }
#if CONTROLLER_INTERFACE_VERSION_MINOR >= 44
        for (auto &reference : on_export_reference_interfaces_list()) {
            references.push_back(reference);
        }
#endif
        for (const auto &reference : references) {
            if (reference->get_prefix_name().find(get_node()->get_name()) != 0) {
                throw std::runtime_error("a reference's prefix is not the controller");
            }
        }
        ordered_exported_reference_interfaces_ = references;
        return references;
    }

protected:
#if CONTROLLER_INTERFACE_VERSION_MINOR >= 44
    [[deprecated("Replaced by on_export_reference_interfaces_list()")]]
#endif
    virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() { return {}; }
#if CONTROLLER_INTERFACE_VERSION_MINOR >= 44
    virtual std::vector<hardware_interface::CommandInterface::SharedPtr> on_export_reference_interfaces_list() { return {}; }
#endif
    virtual return_type update_reference_from_subscribers(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;
    virtual return_type update_and_write_commands(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;

    std::vector<double> reference_interfaces_;
    std::vector<hardware_interface::CommandInterface::SharedPtr> ordered_exported_reference_interfaces_;
};

}  // namespace controller_interface

#endif
