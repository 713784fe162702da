#!/usr/bin/env bash
# Builds the module and holds it against the command line: tests, type stubs, notebook; shows the speed.
# Needs python3 with venv, and the package registries; all is installed under the target folder.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
root=$(cd ../.. && pwd)
target="${CARGO_TARGET_DIR:-$root/target}"
venv="$target/python"
python="$venv/bin/python"
export PYTHONDONTWRITEBYTECODE=1

python3 -c 'import ensurepip, venv' 2>/dev/null || "$root/.ci/install" python3-venv
[[ -x $python ]] || python3 -m venv "$venv"
"$python" -m pip install --quiet --disable-pip-version-check -r requirements.txt

./document_types.py --check
export CARGO_TARGET_DIR=$target
"$root/tests/hosts/recording.sh"
# As a user does; pip starts the maturin that it finds.
PATH="$venv/bin:$PATH" "$python" -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --force-reinstall "$root"

export TRUEAXIS_HOSTS="$target/hosts" TRUEAXIS_COMMAND="$target/release/trueaxis" TRUEAXIS_SIMULATOR="$target/release/firmware-sim"
# Away from the sources: what is tested is what was installed.
cd "$target/python"
here="$root/crates/trueaxis-py"
"$python" -m pytest -q -p no:cacheprovider "$here/tests"
"$python" -m mypy.stubtest trueaxis --allowlist "$here/stubtest.txt" --ignore-unused-allowlist
"$python" -m mypy --strict -p trueaxis
# Shown, and no gate: time is the computer's.
"$python" "$here/speed.py"
