// Runs the chainable controller in a chain, on a double of ros2_control (double/): a preceding controller writes
// references, drives follow exactly, and a manager without ROS runs both at 1 kHz through their life cycles, with
// faults. Exit code 0: all assertions passed. SPDX-License-Identifier: MIT OR Apache-2.0
#include "check.hpp"
#include "trueaxis_controller.hpp"

#include <algorithm>
#include <cstdlib>

namespace {

using controller_interface::CallbackReturn;
using controller_interface::return_type;
using hardware_interface::CommandInterface;
using hardware_interface::StateInterface;

constexpr std::int64_t period_ns = 1'000'000;
constexpr double step_m = 40e-6;  // 40 mm/s
// The limiter permits changes of the correction of up to 5 mm/s.
constexpr double led_in_m = 5e-6 + 1e-9;
// A frozen correction decelerates to rest from the largest change per cycle that the tables permit.
constexpr double frozen_m = 1e-8;
const double nan = std::numeric_limits<double>::quiet_NaN();
const std::vector<std::string> joints = { "x", "y", "z" };

struct Controller : trueaxis::ChainableController {
    bool referenced = true;
    bool homed() const override { return referenced; }
    const trueaxis_record_t &record() const { return filter().record(); }
    using ChainableController::set_reference;
};

// A handle for a value, as the manager lends it. Access differs between the releases.
#if TRUEAXIS_ROS_HUMBLE
template <class Interface>
struct Handle {
    Handle(const std::string &prefix, const std::string &name) : interface(prefix, name, &value) {}
    double get() const { return value; }
    void set(double to) { value = to; }
    Interface &lent() { return interface; }
    double value = 0;
    Interface interface;
};
#else
template <class Interface>
struct Handle {
    Handle(const std::string &prefix, const std::string &name) : interface(std::make_shared<Interface>(prefix, name)) {}
    double get() const { return *interface->get_optional(); }
    void set(double to) { CHECK(interface->set_value(to)); }
    std::shared_ptr<Interface> lent() { return interface; }
    std::shared_ptr<Interface> interface;
};
#endif

// Hardware with encoders and with drives that follow exactly.
struct Machine {
    Machine() {
        for (const std::string &joint : joints) {
            command.push_back(std::make_unique<Handle<CommandInterface>>(joint, "position"));
            state.push_back(std::make_unique<Handle<StateInterface>>(joint, "position"));
        }
        stand({ 0.0, 0.0, -0.2 });
    }
    void stand(const std::vector<double> &at) {
        for (std::size_t i = 0; i < at.size(); i++) {
            command[i]->set(at[i]);
            state[i]->set(at[i]);
        }
    }
    std::vector<std::unique_ptr<Handle<CommandInterface>>> command;
    std::vector<std::unique_ptr<Handle<StateInterface>>> state;
};

struct Bench {
    Machine machine;
    Controller controller;
#if TRUEAXIS_ROS_HUMBLE
    std::vector<CommandInterface> references;
#else
    std::vector<CommandInterface::SharedPtr> references;
#endif

    // Takes a controller through its first configuration.
    explicit Bench(const char *tables, bool pass_without_tables = false, std::vector<std::string> names = joints,
                   std::int64_t machine_id = 0, unsigned int rate = 1000) {
        CHECK(controller.init("trueaxis", { { "joints", names },
                                            { "tables", std::string(tables) },
                                            { "machine_id", machine_id },
                                            { "pass_without_tables", pass_without_tables } }) == CallbackReturn::SUCCESS);
        if (controller.configure(rate)) {
            references = controller.export_reference_interfaces();
        }
    }
    bool configured() const { return controller.life == Controller::Life::INACTIVE; }
    std::string said() const { return rclcpp::logged.empty() ? "" : rclcpp::logged.back(); }

    void lend(std::size_t commands = 3, bool crossed = false) {
        std::vector<hardware_interface::LoanedCommandInterface> lent;
        std::vector<hardware_interface::LoanedStateInterface> states;
        for (std::size_t i = 0; i < commands; i++) {
            lent.emplace_back(machine.command[crossed ? commands - 1 - i : i]->lent());
        }
        for (auto &state : machine.state) {
            states.emplace_back(state->lent());
        }
        controller.assign_interfaces(std::move(lent), std::move(states));
    }
    bool activate(bool chained = true) {
        CHECK(controller.set_chained_mode(chained));
        lend();
        return controller.activate();
    }
    // Writes references as the preceding controller does in its update.
    void refer(const double *to) {
        for (std::size_t i = 0; i < 3; i++) {
            hardware_interface::LoanedCommandInterface lent(references[i]);
#if TRUEAXIS_ROS_HUMBLE
            lent.set_value(to[i]);
#else
            CHECK(lent.set_value(to[i]));
#endif
        }
    }
    return_type update(std::int64_t elapsed_ns = period_ns) {
        return_type done = controller.update(rclcpp::Time(), rclcpp::Duration::from_nanoseconds(elapsed_ns));
        follow();
        return done;
    }
    void follow() {
        for (std::size_t i = 0; i < 3; i++) {
            moved[i] = machine.command[i]->get() - before[i];
            before[i] = machine.command[i]->get();
            machine.state[i]->set(before[i]);
        }
    }
#if !TRUEAXIS_ROS_HUMBLE
    // Runs a cycle during which another thread holds a value.
    void cycle_without(bool &held) {
        refer(reference);
        held = true;
        CHECK(controller.update(rclcpp::Time(), rclcpp::Duration(period_ns)) == return_type::OK);
        held = false;
        follow();
    }
#endif
    return_type cycle(std::int64_t elapsed_ns = period_ns) {
        refer(reference);
        return update(elapsed_ns);
    }
    // Runs back and forth at 40 mm/s in x and 20 mm/s in y. No cycle may have a fault or a step beyond the limiter's.
    void run(int cycles) {
        for (int i = 0; i < cycles; i++) {
            way = std::abs(reference[0]) < 0.25 ? way : reference[0] > 0 ? -step_m : step_m;
            reference[0] += way, reference[1] += way / 2;
            CHECK(cycle() == return_type::OK && controller.record().fault == TRUEAXIS_FAULT_NONE);
            CHECK(std::abs(moved[0] - way) < led_in_m && std::abs(moved[1] - way / 2) < led_in_m);
            CHECK(std::abs(moved[2]) < led_in_m);
        }
    }
    double correction(int axis) const { return before[axis] - reference[axis]; }
    double largest() const {
        return std::max({ std::abs(correction(0)), std::abs(correction(1)), std::abs(correction(2)) });
    }

    double reference[3] = { 0, 0, -0.2 }, before[3] = { 0, 0, -0.2 }, moved[3] = {}, way = step_m;
};

void refusals(const char *tables, const char *cut) {
    // Bad `tables`, `joints`, `machine_id` and `update_rate`, in this order: each is reported in one line, and no
    // reference is offered.
    CHECK(!Bench("no/such.tcomp").configured());
    CHECK(rclcpp::logged.back() == "trueaxis: tables 'no/such.tcomp': cannot be read, or empty");
    CHECK(!Bench(cut).configured() && rclcpp::logged.back().find("uncompensated") == std::string::npos);
    std::printf("%s\n", rclcpp::logged.back().c_str());
    CHECK(!Bench("/").configured() && rclcpp::logged.back() == "trueaxis: tables '/': cannot be read, or empty");
    CHECK(!Bench(tables, false, { "x", "y" }).configured());
    CHECK(rclcpp::logged.back() == "trueaxis: joints: found 2, needed 3 to 6");
    CHECK(!Bench(tables, false, { "x", "y", "z", "a", "c", "b", "d" }).configured());
    CHECK(!Bench(tables, false, { "x", "y", "z", "a", "c" }).configured());
    std::printf("%s\n", rclcpp::logged.back().c_str());
    for (std::int64_t id : { std::int64_t{-1}, std::int64_t{1} << 32, std::int64_t{0x12345678} }) {
        CHECK(!Bench(tables, false, joints, id).configured());
    }
    CHECK(!Bench(tables, false, joints, 0, 0).configured());
    CHECK(rclcpp::logged.back() == "trueaxis: update_rate: found 0, needed that of the controller manager, Hz");
    CHECK(!Bench(tables, false, joints, 0, 5).configured());  // longer than the library's longest period
    Controller mistyped;
    CHECK(mistyped.init("trueaxis", { { "tables", std::int64_t{3} } }) == CallbackReturn::ERROR);

    // A wrong number of commands, then a wrong order, then the right ones.
    Bench bench(tables);
    CHECK(bench.configured() && bench.references.size() == 3);
    bench.lend(2);
    CHECK(!bench.controller.activate());
    CHECK(rclcpp::logged.back() == "trueaxis: found 2 commands and 3 states, needed 3");
    bench.lend(3, true);
    CHECK(!bench.controller.activate());
    CHECK(rclcpp::logged.back() == "trueaxis: found z/position and x/position, needed x/position");
    CHECK(bench.activate());
}

// With pass_without_tables, references pass bit for bit, and the records show the fault.
void without_tables(const char *cut) {
    for (const char *file : { cut, "no/such.tcomp" }) {
        Bench bench(file, true);
        CHECK(bench.configured() && rclcpp::logged.back().find("; running uncompensated") != std::string::npos);
        CHECK(bench.activate());
        for (int i = 0; i < 100; i++) {
            bench.reference[0] += step_m;
            CHECK(bench.cycle() == return_type::OK && bench.largest() < 1e-15);
            CHECK(bench.controller.record().fault == TRUEAXIS_FAULT_TABLES_REFUSED);
        }
    }
}

void chain(const char *tables, const char *points) {
    Bench bench(tables);
    auto commands = bench.controller.command_interface_configuration();
    CHECK(commands.names == bench.controller.state_interface_configuration().names);
    CHECK((commands.names == std::vector<std::string>{ "x/position", "y/position", "z/position" }));
    CHECK(commands.type == controller_interface::interface_configuration_type::INDIVIDUAL);
#if TRUEAXIS_ROS_HUMBLE
    CHECK(bench.references[2].get_name() == "trueaxis/z/position");
#else
    CHECK(bench.references[2]->get_name() == "trueaxis/z/position");
#endif
    CHECK(bench.activate());
    // Without references, or with only some, the controller writes nothing.
    bench.machine.command[0]->set(7.0);
    CHECK(bench.update() == return_type::OK && bench.machine.command[0]->get() == 7.0);
    double partly[3] = { 0, nan, -0.2 };
    bench.refer(partly);
    CHECK(bench.update() == return_type::OK && bench.machine.command[0]->get() == 7.0);
    bench.machine.stand({ 0.0, 0.0, -0.2 });
    std::fill(bench.before, bench.before + 3, 0.0), bench.before[2] = -0.2;

    bench.run(3000);
    for (int i = 0; i < 500; i++) {
        CHECK(bench.cycle() == return_type::OK);
    }
    CHECK(bench.largest() > 5e-6);
    std::ofstream(points) << "x_mm,y_mm,z_mm\n" << bench.reference[0] * 1e3 << ',' << bench.reference[1] * 1e3 << ",-200\n";
    std::printf("drive %.9f %.9f %.9f\n", bench.before[0] * 1e3, bench.before[1] * 1e3, bench.before[2] * 1e3);

    // A time beyond 32 bits, or one that runs backwards, is a late cycle, even if its lower 32 bits equal a period. In
    // a late cycle the correction freezes and the reference passes. The reference also passes if no time has passed.
    const std::int64_t wrapped_ns = (std::int64_t{1} << 32) + period_ns;
    for (std::int64_t elapsed_ns : { period_ns * 3 / 2, wrapped_ns, INT64_MAX, -period_ns, INT64_MIN }) {
        double correction = bench.correction(0);
        bench.reference[0] += bench.way;
        CHECK(bench.cycle(elapsed_ns) == return_type::OK);
        CHECK(bench.controller.record().fault == TRUEAXIS_FAULT_LATE_CYCLE);
        CHECK(bench.controller.record().status & TRUEAXIS_STATUS_FROZEN);
        CHECK(std::abs(bench.correction(0) - correction) < frozen_m);
        bench.run(100);
    }
    bench.reference[0] += bench.way;
    CHECK(bench.cycle(0) == return_type::OK && std::abs(bench.moved[0] - bench.way) < led_in_m);
    bench.run(100);

    // After an encoder dropout the correction freezes and the reference passes.
    double correction = bench.correction(0);
    bench.machine.state[0]->set(nan);
    // Both axes go on: one that stopped at once would take the lag that all axes have in common with it.
    bench.reference[0] += bench.way, bench.reference[1] += bench.way / 2;
    CHECK(bench.cycle() == return_type::OK && std::abs(bench.correction(0) - correction) < frozen_m);
    CHECK(bench.controller.record().fault == TRUEAXIS_FAULT_FEEDBACK_NOT_FINITE);
    bench.run(100);

#if !TRUEAXIS_ROS_HUMBLE
    // Another thread holds a state (a dropout), a reference (the last value is used), or a command (the write is
    // missed).
    bench.cycle_without(bench.machine.state[1]->interface->held);
    CHECK(bench.controller.record().fault == TRUEAXIS_FAULT_FEEDBACK_NOT_FINITE);
    bench.run(100);
#if TRUEAXIS_ROS_SHARED_REFERENCES
    bench.cycle_without(bench.references[0]->held);
    CHECK(bench.controller.record().fault == TRUEAXIS_FAULT_NONE && std::abs(bench.moved[0]) < led_in_m);
    bench.run(100);
#endif
    bench.cycle_without(bench.machine.command[1]->interface->held);
    CHECK(bench.controller.missed_writes() == 1 && bench.moved[1] == 0);
    CHECK(bench.cycle() == return_type::OK && std::abs(bench.moved[1]) < 2 * led_in_m);
    bench.run(100);
#endif

    // Switched off and on in operation, and then unreferenced, the correction ramps out and in.
    bench.controller.set_enabled(false);
    bench.run(500);
    CHECK(bench.largest() < 1e-12);
    bench.controller.set_enabled(true);
    bench.run(500);
    CHECK(bench.largest() > 5e-6);
    bench.controller.referenced = false;
    bench.run(500);
    CHECK(bench.largest() < 1e-12);
    bench.controller.referenced = true;
    bench.run(500);

    // The chained mode cannot change while active. Deactivation leaves the corrected command in place. After
    // reactivation nothing is written before a new reference, and a reference at the drives' position causes no jump.
    // The old reference is no longer used.
    CHECK(!bench.controller.set_chained_mode(false) && bench.controller.is_in_chained_mode());
    double stood[3] = { bench.before[0], bench.before[1], bench.before[2] };
    CHECK(bench.controller.deactivate() && bench.machine.command[1]->get() == stood[1]);
    CHECK(bench.activate());
    for (int i = 0; i < 10; i++) {
        CHECK(bench.update() == return_type::OK && bench.moved[0] == 0 && bench.moved[1] == 0 && bench.moved[2] == 0);
    }
    std::copy(stood, stood + 3, bench.reference);
    CHECK(bench.cycle() == return_type::OK);
    CHECK(std::abs(bench.moved[0]) < led_in_m && std::abs(bench.moved[1]) < led_in_m);
    bench.run(1000);
    CHECK(bench.largest() > 5e-6);

    // Outside a chain, references come from `set_reference`, and the last one stays in use from cycle to cycle.
    CHECK(bench.controller.deactivate() && bench.activate(false) && !bench.controller.is_in_chained_mode());
    CHECK(bench.update() == return_type::OK && bench.moved[0] == 0);
    for (std::size_t i = 0; i < 3; i++) {
        bench.reference[i] = bench.before[i];
        bench.controller.set_reference(i, bench.reference[i]);
    }
    for (int i = 0; i < 500; i++) {
        CHECK(bench.update() == return_type::OK && std::abs(bench.moved[0]) < led_in_m);
    }
    CHECK(bench.largest() > 5e-6);
    CHECK(bench.controller.deactivate() && bench.activate());
    std::copy(bench.before, bench.before + 3, bench.reference);
    bench.run(1000);

    // A reference that is not a number, or that jumps, makes the controller hold its commands and return an error until
    // it is activated again.
    for (double bad : { nan, std::numeric_limits<double>::infinity(), bench.reference[1] + 0.05 }) {
        double good = bench.reference[1];
        bench.reference[1] = bad;
        CHECK(bench.cycle() == return_type::ERROR && bench.moved[0] == 0 && bench.moved[1] == 0 && bench.moved[2] == 0);
        bench.reference[1] = good;
        CHECK(bench.cycle() == return_type::ERROR && bench.moved[1] == 0);
        CHECK(bench.controller.deactivate());
        CHECK(rclcpp::logged.back().find("trueaxis: stopped by fault ") == 0 && rclcpp::logged.back().back() == '1');
        CHECK(bench.activate());
        std::copy(bench.before, bench.before + 3, bench.reference);
        bench.run(500);
    }

    // Nothing moves if the first reference is too far away to reach in a cycle, or if an encoder gives no reading.
    CHECK(bench.controller.deactivate() && bench.activate());
    std::copy(bench.before, bench.before + 3, bench.reference);
    bench.reference[0] += 0.05;
    CHECK(bench.cycle() == return_type::ERROR && bench.moved[0] == 0);
    CHECK(bench.controller.deactivate() && bench.activate());
    std::copy(bench.before, bench.before + 3, bench.reference);
    bench.machine.state[2]->set(nan);
    CHECK(bench.cycle() == return_type::ERROR && bench.moved[0] == 0);
    CHECK(bench.cycle() == return_type::OK);  // read again
    bench.run(500);
}

}  // namespace

int main(int argc, char **argv) {
    CHECK(argc == 4);
    refusals(argv[1], argv[2]);
    without_tables(argv[2]);
    chain(argv[1], argv[3]);
    std::printf("passed\n");
    return 0;
}
