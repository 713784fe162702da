"""Lists all tests by name."""
import check_adaptation
import check_calibration
import check_cost
import check_dynamics
import check_faults
import check_files
import check_friction
import check_hosts
import check_machines
import check_motion
import check_units

MODULES = (
    check_files,
    check_motion,
    check_units,
    check_calibration,
    check_dynamics,
    check_adaptation,
    check_faults,
    check_machines,
    check_friction,
    check_hosts,
    check_cost,
)
ALL = {test.__name__: test for module in MODULES for test in module.TESTS}
