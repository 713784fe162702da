// Geometric error compensation as a filter in a ros2_control update: one call between a controller's command and the
// hardware's. A plain C++17 header on top of the C library, which needs no ROS. Link libtrueaxis_capi.a.
//
// SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef TRUEAXIS_FILTER_HPP
#define TRUEAXIS_FILTER_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "trueaxis.h"

namespace trueaxis {

// Corrects commands and readings in metres and radians (REP 103). Inside, the tables are in mm and degrees.
class Filter {
public:
    // Loads a .tcomp. Call it in on_configure: it allocates and takes about 40 KiB of stack. If it returns false,
    // `reason()` says why and the filter passes commands uncompensated. `period_ns`: period of the controller manager.
    // `axes`: number of axes of the machine, 3 to 6.
    bool configure(const std::uint8_t *file, std::size_t length, std::uint32_t axes, std::uint32_t period_ns,
                   std::uint32_t machine_id = 0) {
        started_ = false;
        axes_ = axes;
        period_ns_ = period_ns;
        std::uint8_t fault = TRUEAXIS_FAULT_ABI_MISMATCH;
        reason_ = "header and library differ in version or precision";
        if (trueaxis_check_abi(TRUEAXIS_ABI_VERSION) == TRUEAXIS_OK) {
            fault = TRUEAXIS_FAULT_TABLES_REFUSED;
            trueaxis_error_t error{};
            error.size = sizeof error;
            trueaxis_tables_info_t info{};
            info.size = sizeof info;
            if (trueaxis_tables_info(file, length, &info, &error) != TRUEAXIS_OK) {
                reason_ = error.text;
            } else if (info.axes != axes) {
                reason_ = "the tables are for axes " + std::string(info.letters) + ", the machine has " + std::to_string(axes);
            } else {
                memory_.assign(static_cast<std::size_t>(info.memory_bytes + 7) / 8, 0);
                bool built = trueaxis_loop_build(&loop_, sizeof loop_, file, length, machine_id, period_ns, memory_.data(),
                                                 memory_.size() * 8, &error) == TRUEAXIS_OK;
                reason_ = built ? "" : error.text;
            }
        }
        if (!reason_.empty()) {
            if (trueaxis_loop_bypass(&loop_, sizeof loop_, axes, fault, period_ns) != TRUEAXIS_OK) {
                axes_ = 0;  // no such number of axes, or period: update refuses
            }
        }
        return reason_.empty();
    }

    // Starts with a fresh state. Call it in on_activate. The first command passes unchanged; the limiter then ramps the
    // correction in.
    bool activate() {
        started_ = axes_ != 0 && trueaxis_start(&loop_, &state_, sizeof state_, period_ns_) == TRUEAXIS_OK;
        input_ = trueaxis_input_t{};
        input_.size = sizeof input_;
        output_ = trueaxis_output_t{};
        output_.size = sizeof output_;
        return started_;
    }

    // Releases a stop in the next update. The command must then be near the held position.
    void reset() { input_.reset = 1; }

    // Runs one update; real-time safe. `command`, `position`: m and rad, in the order of the tables (X Y Z, then rotary
    // axes); a position that is not finite is a dropout. `elapsed_ns`: the period as measured by the controller
    // manager; a negative value, or one beyond 32 bits, is a late cycle. `homed`: whether all axes are referenced.
    // `drive`: receives the commands for the drives. Returns false, with `drive` unchanged, if there is nothing to
    // send.
    bool update(const double *command, const double *position, std::int64_t elapsed_ns, bool homed, bool enable,
                double *drive) {
        if (!started_) {
            return false;
        }
        for (std::uint32_t i = 0; i < axes_; i++) {
            input_.command[i] = command[i] * to_tables(i);
            input_.feedback[i] = position[i] * to_tables(i);
        }
        input_.elapsed_ns = trueaxis_elapsed_ns(elapsed_ns);
        input_.homed = homed;
        input_.enable = enable;
        trueaxis_result_t done = trueaxis_step(&loop_, &state_, &input_, nullptr, nullptr, &output_);
        input_.reset = 0;
        if (done != TRUEAXIS_OK) {
            return false;
        }
        for (std::uint32_t i = 0; i < axes_; i++) {
            drive[i] = output_.drive[i] / to_tables(i);
        }
        return true;
    }

    // Whether the output is held. The hardware interface must then return an error, or the controller stop the
    // trajectory.
    bool stop_requested() const { return (output_.record.status & TRUEAXIS_STATUS_STOP_REQUEST) != 0; }
    // Position for the controller, m or rad, without the correction, which would otherwise look like a following error.
    double feedback(std::uint32_t axis) const { return output_.feedback[axis] / to_tables(axis); }
    const trueaxis_record_t &record() const { return output_.record; }
    // Reason for running uncompensated, in one line; empty if compensated. `refusal` returns the reason without the
    // surrounding words.
    std::string reason() const { return reason_.empty() ? "" : "trueaxis: " + reason_ + "; running uncompensated"; }
    const std::string &refusal() const { return reason_; }

private:
    static double to_tables(std::uint32_t axis) { return axis < 3 ? 1000.0 : 57.29577951308232; }

    std::uint32_t axes_ = 0, period_ns_ = 0;
    bool started_ = false;
    std::string reason_ = "not configured";
    std::vector<std::uint64_t> memory_;
    trueaxis_loop_t loop_{};
    trueaxis_state_t state_{};
    trueaxis_input_t input_{};
    trueaxis_output_t output_{};
};

}  // namespace trueaxis

#endif
