// Runs the filter as a hardware component would, without ROS: read, update, write at 1 kHz, with faults. Exit code 0:
// all assertions passed. SPDX-License-Identifier: MIT OR Apache-2.0
#include "check.hpp"
#include "trueaxis_filter.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>

constexpr std::int64_t period_ns = 1'000'000;

int main(int argc, char **argv) {
    CHECK(argc == 3);
    std::ifstream stream(argv[1], std::ios::binary);
    std::vector<char> bytes{ std::istreambuf_iterator<char>(stream), {} };
    auto *data = reinterpret_cast<const std::uint8_t *>(bytes.data());

    trueaxis::Filter filter;
    double command[3] = { 0, 0, -0.2 }, position[3] = { 0, 0, -0.2 }, drive[3] = { 0, 0, -0.2 };
    CHECK(!filter.update(command, position, period_ns, true, true, drive));  // not configured
    CHECK(!filter.configure(data, bytes.size() / 2, 3, period_ns));         // on_configure: a file cut short
    std::printf("%s\n", filter.reason().c_str());
    CHECK(filter.activate() && filter.update(command, position, period_ns, true, true, drive));
    CHECK(drive[2] == -0.2 && filter.record().fault == TRUEAXIS_FAULT_TABLES_REFUSED);
    CHECK(!filter.configure(data, bytes.size(), 5, period_ns));
    std::printf("%s\n", filter.reason().c_str());
    CHECK(!filter.configure(data, bytes.size(), 3, period_ns, 0x12345678));
    std::printf("%s\n", filter.reason().c_str());

    CHECK(filter.configure(data, bytes.size(), 3, period_ns));
    CHECK(filter.activate());
    auto cycle = [&](std::int64_t elapsed_ns = period_ns) {
        CHECK(filter.update(command, position, elapsed_ns, true, true, drive));
        for (int i = 0; i < 3; i++) {
            position[i] = drive[i];  // drives that follow exactly
        }
    };
    cycle();
    CHECK(drive[0] == command[0]);  // the first command passes
    for (int i = 0; i < 3000; i++) {
        command[0] += 40e-6, command[1] += 20e-6;  // 40 and 20 mm/s
        double before[3] = { drive[0], drive[1], drive[2] };
        cycle();
        CHECK(std::abs(drive[0] - before[0] - 40e-6) < 6e-6 && filter.record().fault == TRUEAXIS_FAULT_NONE);
        CHECK(std::abs(filter.feedback(0) - command[0]) < 45e-6);
    }
    // After an encoder dropout the correction freezes and the command passes.
    double geometric = filter.record().correction[0];
    command[0] += 40e-6;
    position[0] = std::numeric_limits<double>::quiet_NaN();
    cycle();
    CHECK(filter.record().fault == TRUEAXIS_FAULT_FEEDBACK_NOT_FINITE && (filter.record().status & TRUEAXIS_STATUS_FROZEN));
    CHECK(filter.record().correction[0] == geometric && std::abs(drive[0] - command[0]) < 50e-6);
    // Cycles that are late by half a period, late by 2^32 ns (invisible in 32 bits), or on a clock that was set back.
    for (std::int64_t elapsed_ns : { period_ns * 3 / 2, (std::int64_t{1} << 32) + period_ns, -period_ns }) {
        cycle(elapsed_ns);
        CHECK(filter.record().fault == TRUEAXIS_FAULT_LATE_CYCLE && !filter.stop_requested());
    }
    for (int i = 0; i < 500; i++) {
        cycle();
    }
    CHECK(filter.record().fault == TRUEAXIS_FAULT_NONE);
    std::ofstream(argv[2]) << "x_mm,y_mm,z_mm\n" << std::to_string(command[0] * 1e3) << ',' << command[1] * 1e3 << ",-200\n";
    std::printf("drive %.9f %.9f %.9f\n", drive[0] * 1e3, drive[1] * 1e3, drive[2] * 1e3);

    // A command that jumps makes the filter hold and request a stop. After a reset near the held position it follows
    // again.
    double stood = drive[0], good = command[0];
    command[0] += 0.05;
    cycle();
    CHECK(filter.stop_requested() && drive[0] == stood);
    command[0] = good;
    cycle();
    CHECK(filter.stop_requested());  // latched
    filter.reset();
    cycle();
    CHECK(!filter.stop_requested());
    std::printf("passed\n");
    return 0;
}
