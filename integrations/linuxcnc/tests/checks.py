"""All tests by name."""
import check_faults
import check_files
import check_motion

ALL = {test.__name__: test for module in (check_files, check_motion, check_faults) for test in module.TESTS}
