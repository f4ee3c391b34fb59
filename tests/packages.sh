#!/bin/sh
# packages.sh LIBRARY: Python's wheel, its source package, which compiles the library, and an editable
# install, each in a fresh environment without network; mypy --strict on the package and on a user's
# script. LIBRARY: libdelassus.so.0 for the wheel. PYTHON: an interpreter with numpy and scipy; skipped
# with a line where it has no pip, setuptools, wheel or venv.
set -eu
library=$(realpath "$1")
python=${PYTHON:-/usr/bin/python3}
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
source=$root/source
export OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1
unset DELASSUS_LIBRARY LD_LIBRARY_PATH PYTHONPATH
fail() {
  cat "$root/log"
  echo "check-packages: $*"
  exit 1
}
: > "$root/log"
"$python" -c 'import setuptools, wheel, pip, venv, ensurepip, numpy, scipy' 2> /dev/null ||
  { tests/skip.sh 'packages of Python, no pip, setuptools, wheel or venv'; exit; }
# the tree without what was built
mkdir "$source"
tar cf - --exclude=./build --exclude=./build-* --exclude=./.git --exclude='*.egg-info' . | (cd "$source" && tar xf -)
cat > "$root/user.py" << 'END'
import numpy as np

import delassus

s: delassus.Solution = delassus.solve(np.eye(2), [-1.0, 0.25], 0.3)
certificate = delassus.certify(np.eye(2), [-1.0, 0.25], 0.3, s.r)
R = delassus.reduce(np.array([[3.0, 1.0], [1.0, 2.0]]), [[0.0], [1.0]], [[1.0], [0.0]])
t = R.solve(0.2, f=[5.0, -10.0], method="nlgs", tol=1e-10)
assert t.x is not None and t.status == delassus.DLS_OK
print(s.words, s.r.tolist(), round(float(t.x[0]), 4), certificate.residual == s.residual)
try:
    delassus.solve([[1.0, 0.0], [0.0, float("nan")]], [-1.0, 0.0], 0.3)
except ValueError as error:
    print(error)
END
wanted='solved [[1.0, -0.25]] 0.9375 True
W[3]: is not finite (row 1, column 1)'
environment() { # name, what to install
  "$python" -m venv --system-site-packages "$root/$1" > "$root/log" 2>&1 || fail "$1: no environment"
  "$root/$1/bin/pip" install --no-index --no-build-isolation --no-deps $2 > "$root/log" 2>&1 || fail "$1: pip install"
}
works() { # name
  (cd "$root" && "$1/bin/python" user.py) > "$root/printed" 2> "$root/log" || fail "$1: the script ends badly"
  [ "$(sed 's/ *$//' "$root/printed")" = "$wanted" ] || { cat "$root/printed" > "$root/log"; fail "$1: printed something else"; }
  echo "Python by the $1: installs without network and works"
}
in_source() { # function of setuptools that writes a package
  (cd "$source" && "$python" -c "from setuptools import build_meta as b; b.$1('$root')") > "$root/log" 2>&1 || fail "$1"
}

DELASSUS_LIBRARY=$library in_source build_wheel
"$python" - "$root"/delassus-*.whl > "$root/log" 2>&1 << 'END' || fail 'the wheel lacks a file'
import sys, zipfile
wheel = zipfile.ZipFile(sys.argv[1])
names = {name.split("/", 1)[1] for name in wheel.namelist()}
missing = {"LICENSE", "METADATA", "py.typed", "libdelassus.so.0", "libdelassus-files.so.0", "contact.py"} - names
assert not missing, missing
metadata = wheel.read(next(n for n in wheel.namelist() if n.endswith("METADATA"))).decode()
for line in ("Name: delassus", "License: BSD-3-Clause", "Requires-Dist: numpy", "Requires-Python: >=3.8"):
    assert line in metadata, line
END
environment wheel "$root"/delassus-*.whl
works wheel

in_source build_sdist
! tar tzf "$root"/delassus-*.tar.gz | grep -E '\.(so|o|a)(\.|$)' > "$root/log" || fail 'the source package has what was built'
CFLAGS=-O0 environment sdist "$root"/delassus-*.tar.gz
works sdist

mkdir -p "$source/build"
cp "$library" "$source/build/libdelassus.so.0"
export DELASSUS_LIBRARY="$library"
environment editable "--editable $source"
unset DELASSUS_LIBRARY
works editable
sed -i 's/^def certify/changed = 1\n\n\n&/' "$source/src/python/delassus/contact.py"
"$root/editable/bin/python" -c 'import delassus.contact as c; assert c.changed' > "$root/log" 2>&1 || fail 'editable: a change is not seen'

if command -v mypy > /dev/null; then
  mypy --config-file pyproject.toml --python-executable "$python" --cache-dir "$root/mypy" src/python/delassus > "$root/log" 2>&1 ||
    fail 'mypy --strict: the package'
  check() { (cd "$root" && mypy --strict --python-executable "$root/wheel/bin/python" --cache-dir "$root/mypy" "$1"); }
  check user.py > "$root/log" 2>&1 || fail 'mypy --strict: a script'
  sed 's/method="nlgs"/method=3/' "$root/user.py" > "$root/wrong.py"
  check wrong.py > "$root/log" 2>&1 && fail 'mypy --strict: takes a method that is a number'
  echo 'mypy --strict: the package and a script pass'
else
  tests/skip.sh 'mypy'
fi
