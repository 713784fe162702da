"""All tests by name."""
import check_cost
import check_faults
import check_files
import check_machines
import check_motion

ALL = {test.__name__: test for module in (check_files, check_motion, check_faults, check_machines, check_cost) for test in module.TESTS}
