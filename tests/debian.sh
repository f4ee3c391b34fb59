#!/bin/sh
# debian.sh: builds the packages of debian/ in a copy of the tree and asks lintian for errors and warnings;
# libdelassus0 depends on no HDF5, MUMPS or MPI. Skipped with a line without dpkg-buildpackage, debhelper or lintian.
set -eu
for tool in dpkg-buildpackage dh dh_python3 lintian; do
  command -v $tool > /dev/null || { tests/skip.sh "packages of Debian, no $tool"; exit; }
done
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
mkdir "$root/delassus"
tar cf - --exclude=./build --exclude=./build-* --exclude=./.git --exclude='*.egg-info' . | tar xf - -C "$root/delassus"
cd "$root/delassus"
dpkg-buildpackage -us -uc > ../log 2>&1 || { tail -50 ../log; echo 'check-debian: dpkg-buildpackage'; exit 1; }
cd ..
lintian --allow-root --fail-on error,warning *.changes || { echo 'check-debian: lintian'; exit 1; }
! dpkg -I libdelassus0_*.deb | grep -i -E 'depends:.*(hdf5|mumps|mpi)' || { echo 'check-debian: libdelassus0 depends on it'; exit 1; }
echo "debian: $(ls ./*.deb | wc -l) packages, no error or warning of lintian"
