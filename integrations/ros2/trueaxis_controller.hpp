// Geometric error compensation as a chainable ros2_control controller: takes reference positions, writes corrected
// commands. For Humble, Jazzy, Kilted and Rolling; C++17. Needs trueaxis_filter.hpp beside it, and libtrueaxis_capi.a.
//
//   #include "trueaxis_controller.hpp"
//   #include "pluginlib/class_list_macros.hpp"
//   PLUGINLIB_EXPORT_CLASS(trueaxis::ChainableController, controller_interface::ChainableControllerInterface)
//
// SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef TRUEAXIS_CONTROLLER_HPP
#define TRUEAXIS_CONTROLLER_HPP

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "controller_interface/chainable_controller_interface.hpp"
#include "rclcpp/logging.hpp"
#if __has_include("controller_interface/version.h")  // since Jazzy, in late releases of Humble too
#include "controller_interface/version.h"
#else
#define CONTROLLER_INTERFACE_VERSION_MAJOR 2
#define CONTROLLER_INTERFACE_VERSION_MINOR 0
#endif

#include "trueaxis_filter.hpp"

// `update_reference_from_subscribers` takes time and period since Jazzy.
#define TRUEAXIS_ROS_HUMBLE (CONTROLLER_INTERFACE_VERSION_MAJOR < 4)
// References are shared objects since Jazzy 4.44, Kilted 5.13 and Rolling 6.5; before that they point into
// `reference_interfaces_`.
#define TRUEAXIS_ROS_SHARED_REFERENCES                                                     \
    ((CONTROLLER_INTERFACE_VERSION_MAJOR == 4 && CONTROLLER_INTERFACE_VERSION_MINOR >= 44) || \
     (CONTROLLER_INTERFACE_VERSION_MAJOR == 5 && CONTROLLER_INTERFACE_VERSION_MINOR >= 13) || \
     (CONTROLLER_INTERFACE_VERSION_MAJOR == 6 && CONTROLLER_INTERFACE_VERSION_MINOR >= 5) ||  \
     CONTROLLER_INTERFACE_VERSION_MAJOR > 6)

namespace trueaxis {

// Claims `JOINT/position` of every joint, as command and as state, and offers `CONTROLLER/JOINT/position` as references.
// Interfaces are in metres and radians (REP 103); the tables inside are in mm and degrees. Parameters:
//
//   joints               names in the tables' order, X Y Z, then rotary axes; 3 to 6
//   tables               path of the .tcomp
//   machine_id           id of the machine that the tables must be for; 0: any
//   pass_without_tables  false: refused tables make the configuration fail. true: references then pass uncompensated
//   update_rate          Hz. On Humble it must be set to the manager's rate; elsewhere that is the default
//
// A derived class can take references from elsewhere while no controller precedes this one
// (`update_reference_from_subscribers`, `set_reference`), and report whether the axes are referenced (`homed`).
class ChainableController : public controller_interface::ChainableControllerInterface {
public:
    using CallbackReturn = controller_interface::CallbackReturn;
    using return_type = controller_interface::return_type;

    CallbackReturn on_init() override {
        try {
            auto_declare<std::vector<std::string>>("joints", {});
            auto_declare<std::string>("tables", "");
            auto_declare<std::int64_t>("machine_id", 0);
            auto_declare<bool>("pass_without_tables", false);
        } catch (const std::exception &error) {
            RCLCPP_ERROR(get_node()->get_logger(), "trueaxis: %s", error.what());
            return CallbackReturn::ERROR;
        }
        return CallbackReturn::SUCCESS;
    }

    CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
        joints_ = get_node()->get_parameter("joints").as_string_array();
        const std::string path = get_node()->get_parameter("tables").as_string();
        const std::int64_t machine_id = get_node()->get_parameter("machine_id").as_int();
        if (joints_.size() < 3 || joints_.size() > axes_max) {
            return refuse("joints: found " + std::to_string(joints_.size()) + ", needed 3 to 6");
        }
        if (machine_id < 0 || machine_id > std::numeric_limits<std::uint32_t>::max()) {
            return refuse("machine_id: found " + std::to_string(machine_id) + ", needed 0 to 4294967295");
        }
        if (get_update_rate() == 0) {
            return refuse("update_rate: found 0, needed that of the controller manager, Hz");
        }
        const double period_ns = std::round(1e9 / get_update_rate());
        std::ostringstream content;
        const bool read = static_cast<bool>(content << std::ifstream(path, std::ios::binary).rdbuf());
        const std::string bytes = content.str();
        if (!filter_.configure(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size(),
                               static_cast<std::uint32_t>(joints_.size()), static_cast<std::uint32_t>(period_ns),
                               static_cast<std::uint32_t>(machine_id))) {
            const std::string why = "tables '" + path + "': " + (read ? filter_.refusal() : "cannot be read, or empty");
            if (!get_node()->get_parameter("pass_without_tables").as_bool()) {
                return refuse(why);
            }
            RCLCPP_WARN(get_node()->get_logger(), "trueaxis: %s; running uncompensated", why.c_str());
        }
        return CallbackReturn::SUCCESS;
    }

    controller_interface::InterfaceConfiguration command_interface_configuration() const override { return positions(); }
    controller_interface::InterfaceConfiguration state_interface_configuration() const override { return positions(); }

    // The controller writes nothing until every reference is a number: drives keep their commanded position.
    CallbackReturn on_activate(const rclcpp_lifecycle::State &) override {
        if (command_interfaces_.size() != joints_.size() || state_interfaces_.size() != joints_.size()) {
            return refuse("found " + std::to_string(command_interfaces_.size()) + " commands and " +
                          std::to_string(state_interfaces_.size()) + " states, needed " + std::to_string(joints_.size()));
        }
        const std::vector<std::string> names = positions().names;
        for (std::size_t i = 0; i < joints_.size(); i++) {
            if (command_interfaces_[i].get_name() != names[i] || state_interfaces_[i].get_name() != names[i]) {
                return refuse("found " + command_interfaces_[i].get_name() + " and " + state_interfaces_[i].get_name() +
                              ", needed " + names[i]);
            }
        }
        forget_references();
        following_ = false;
        return filter_.activate() ? CallbackReturn::SUCCESS : refuse(filter_.refusal());
    }

    // The last corrected commands stay in place, so no drive moves.
    CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override {
        if (following_ && filter_.stop_requested()) {
            const trueaxis_record_t &record = filter_.record();
            RCLCPP_ERROR(get_node()->get_logger(), "trueaxis: stopped by fault %u of axis %u", unsigned{record.fault},
                         unsigned{record.fault_axis});
        }
        following_ = false;
        return CallbackReturn::SUCCESS;
    }

    // Ramps the correction in or out through its limiter. May be called from any thread.
    void set_enabled(bool enabled) { enabled_.store(enabled, std::memory_order_relaxed); }
    // Number of writes prevented because another thread had locked a command. The drive then keeps its previous
    // command.
    std::uint64_t missed_writes() const { return missed_writes_.load(std::memory_order_relaxed); }

protected:
    static constexpr std::size_t axes_max = 6;

#if TRUEAXIS_ROS_SHARED_REFERENCES
    std::vector<hardware_interface::CommandInterface::SharedPtr> on_export_reference_interfaces_list() override {
        std::vector<hardware_interface::CommandInterface::SharedPtr> references;
        for (const std::string &joint : joints_) {
            references.push_back(
                std::make_shared<hardware_interface::CommandInterface>(get_node()->get_name(), joint + "/position"));
        }
        return references;
    }
#else
    std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override {
        reference_interfaces_.assign(joints_.size(), std::numeric_limits<double>::quiet_NaN());
        std::vector<hardware_interface::CommandInterface> references;
        for (std::size_t i = 0; i < joints_.size(); i++) {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // of early Jazzy, which has no other way
            references.push_back(hardware_interface::CommandInterface(get_node()->get_name(), joints_[i] + "/position",
                                                                      &reference_interfaces_[i]));
#pragma GCC diagnostic pop
        }
        return references;
    }
#endif

    // The next controller in the chain must not start from references that the previous one wrote.
    bool on_set_chained_mode(bool) override {
        forget_references();
        return true;
    }

    // Without a preceding controller, references stay unchanged.
#if TRUEAXIS_ROS_HUMBLE
    return_type update_reference_from_subscribers() override { return return_type::OK; }
#else
    return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) override {
        return return_type::OK;
    }
#endif

    // Returns ERROR if a stop is requested: commands are then held until the controller is activated again. Real-time
    // safe.
    return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &period) override {
        double position[axes_max], drive[axes_max];
        bool wanted = true, read = true;
        for (std::size_t i = 0; i < joints_.size(); i++) {
            read_reference(i);
            position[i] = value_of(state_interfaces_[i]);
            wanted = wanted && std::isfinite(reference_[i]);
            read = read && std::isfinite(position[i]);
        }
        const std::int64_t elapsed_ns = period.nanoseconds();
        if (!following_) {
            if (!wanted) {
                return return_type::OK;
            }
            // Start at the machine's position, so that a first reference too far away to reach in a cycle counts as a
            // jump.
            following_ = read && filter_.update(position, position, elapsed_ns, homed(), enabled(), drive);
            if (!following_) {
                return return_type::ERROR;
            }
        }
        if (!filter_.update(reference_, position, elapsed_ns, homed(), enabled(), drive)) {
            return return_type::ERROR;
        }
        for (std::size_t i = 0; i < joints_.size(); i++) {
            if (!write(command_interfaces_[i], drive[i])) {
                missed_writes_.fetch_add(1, std::memory_order_relaxed);
            }
        }
        return filter_.stop_requested() ? return_type::ERROR : return_type::OK;
    }

    // Whether all axes are referenced. If not, references pass uncorrected. Called in every update, so it must be
    // real-time safe.
    virtual bool homed() const { return true; }  // absolute encoders

    // Sets the reference of an axis, m or rad; NaN: none. For use in `update_reference_from_subscribers`.
    void set_reference(std::size_t axis, double reference) {
#if TRUEAXIS_ROS_SHARED_REFERENCES
        static_cast<void>(ordered_exported_reference_interfaces_[axis]->set_value(reference));
#else
        reference_interfaces_[axis] = reference;
#endif
    }

    const Filter &filter() const { return filter_; }

private:
    CallbackReturn refuse(const std::string &why) const {
        RCLCPP_ERROR(get_node()->get_logger(), "trueaxis: %s", why.c_str());
        return CallbackReturn::FAILURE;
    }

    controller_interface::InterfaceConfiguration positions() const {
        controller_interface::InterfaceConfiguration configuration;
        configuration.type = controller_interface::interface_configuration_type::INDIVIDUAL;
        for (const std::string &joint : joints_) {
            configuration.names.push_back(joint + "/position");
        }
        return configuration;
    }

    bool enabled() const { return enabled_.load(std::memory_order_relaxed); }

    void forget_references() {
#if TRUEAXIS_ROS_SHARED_REFERENCES
        const std::size_t exported = ordered_exported_reference_interfaces_.size();
#else
        const std::size_t exported = reference_interfaces_.size();
#endif
        for (std::size_t i = 0; i < exported; i++) {
            set_reference(i, std::numeric_limits<double>::quiet_NaN());
        }
        for (double &reference : reference_) {
            reference = std::numeric_limits<double>::quiet_NaN();
        }
    }

    // If another thread holds the reference, the value read last is kept.
    void read_reference(std::size_t axis) {
#if TRUEAXIS_ROS_SHARED_REFERENCES
        reference_[axis] = ordered_exported_reference_interfaces_[axis]->get_optional().value_or(reference_[axis]);
#else
        reference_[axis] = reference_interfaces_[axis];
#endif
    }

    // Since Jazzy a value may be missing because another thread holds it. That counts as a dropout.
    template <class Interface, class = void>
    struct HasOptional : std::false_type {};
    template <class Interface>
    struct HasOptional<Interface, std::void_t<decltype(std::declval<const Interface &>().get_optional())>> : std::true_type {};

    template <class Interface>
    static double value_of(const Interface &interface) {
        if constexpr (HasOptional<Interface>::value) {
            return interface.get_optional().value_or(std::numeric_limits<double>::quiet_NaN());
        } else {
            return interface.get_value();
        }
    }

    template <class Interface>
    static bool write(Interface &interface, double value) {
        if constexpr (std::is_void_v<decltype(interface.set_value(value))>) {
            interface.set_value(value);
            return true;
        } else {
            return interface.set_value(value);
        }
    }

    std::vector<std::string> joints_;
    double reference_[axes_max];
    bool following_ = false;
    std::atomic<bool> enabled_{true};
    std::atomic<std::uint64_t> missed_writes_{0};
    Filter filter_;
};

}  // namespace trueaxis

#endif
