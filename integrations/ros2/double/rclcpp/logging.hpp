// A double of the parts of rclcpp, rclcpp_lifecycle and controller_interface that are the same in every release and
// that the controller and its base classes use. Names and signatures are those of rclcpp 16 (Humble) to 30; the
// implementation is independent. SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef DOUBLE_RCLCPP_HPP
#define DOUBLE_RCLCPP_HPP

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace rclcpp {

class Time {
public:
    explicit Time(std::int64_t nanoseconds = 0) : nanoseconds_(nanoseconds) {}
    std::int64_t nanoseconds() const { return nanoseconds_; }

private:
    std::int64_t nanoseconds_;
};

class Duration {
public:
    explicit Duration(std::int64_t nanoseconds) : nanoseconds_(nanoseconds) {}
    static Duration from_nanoseconds(std::int64_t nanoseconds) { return Duration(nanoseconds); }
    std::int64_t nanoseconds() const { return nanoseconds_; }

private:
    std::int64_t nanoseconds_;
};

struct Logger {};
inline std::vector<std::string> logged;

template <class... Values>
void log(const Logger &, const char *format, Values... values) {
    char line[1024];
    std::snprintf(line, sizeof line, format, values...);
    logged.push_back(line);
}
#define RCLCPP_ERROR(logger, ...) ::rclcpp::log(logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) ::rclcpp::log(logger, __VA_ARGS__)

using ParameterValue = std::variant<bool, std::int64_t, std::string, std::vector<std::string>>;

class Parameter {
public:
    explicit Parameter(ParameterValue value) : value_(std::move(value)) {}
    bool as_bool() const { return std::get<bool>(value_); }
    std::int64_t as_int() const { return std::get<std::int64_t>(value_); }
    std::string as_string() const { return std::get<std::string>(value_); }
    std::vector<std::string> as_string_array() const { return std::get<std::vector<std::string>>(value_); }
    template <class T>
    T get_value() const {
        if constexpr (std::is_same_v<T, int>) {
            return static_cast<int>(as_int());
        } else {
            return std::get<T>(value_);
        }
    }

private:
    ParameterValue value_;
};

}  // namespace rclcpp

namespace rclcpp_lifecycle {

class State {
public:
    State(std::uint8_t id, std::string label) : id_(id), label_(std::move(label)) {}
    std::uint8_t id() const { return id_; }
    std::string label() const { return label_; }

private:
    std::uint8_t id_;
    std::string label_;
};

class LifecycleNode {
public:
    explicit LifecycleNode(std::string name) : name_(std::move(name)) {}
    const char *get_name() const { return name_.c_str(); }
    rclcpp::Logger get_logger() const { return {}; }
    bool has_parameter(const std::string &name) const { return declared_.count(name) != 0; }
    template <class T>
    T declare_parameter(const std::string &name, const T &value) {
        auto found = given.find(name);
        if constexpr (std::is_same_v<T, int>) {
            declared_.emplace(name, found == given.end() ? rclcpp::ParameterValue(std::int64_t{value}) : found->second);
        } else {
            declared_.emplace(name, found == given.end() ? rclcpp::ParameterValue(value) : found->second);
        }
        return get_parameter(name).get_value<T>();  // throws where it is given as another type
    }
    rclcpp::Parameter get_parameter(const std::string &name) const { return rclcpp::Parameter(declared_.at(name)); }

    std::map<std::string, rclcpp::ParameterValue> given;  // of the parameter file
    std::map<std::string, rclcpp::ParameterValue> &declared() { return declared_; }

private:
    std::string name_;
    std::map<std::string, rclcpp::ParameterValue> declared_;
};

namespace node_interfaces {
class LifecycleNodeInterface {
public:
    enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };

    virtual CallbackReturn on_configure(const State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_cleanup(const State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_activate(const State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_deactivate(const State &) { return CallbackReturn::SUCCESS; }
    virtual ~LifecycleNodeInterface() = default;
};
}  // namespace node_interfaces

}  // namespace rclcpp_lifecycle

#endif
