#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The scripts that 3D Slicer starts: each describes its module and runs it, from another folder and with libraries around
# that are not Quench's. All else of the modules is tests/cli/slicer_module.py. Ends with 77 without xmllint.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
command -v xmllint >/dev/null || { echo "xmllint is not installed (libxml2-utils)"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${QUENCH:-quench}" sample root --branches 4 --resolution 40 -o root.nrrd >/dev/null 2>&1
mkdir libraries
echo broken >libraries/libtbb.so.12 # as Slicer brings its own
export LD_LIBRARY_PATH="$folder/libraries"
call() { # MODULE ARGUMENTS: with nothing on stderr, which Slicer would show as an error
  "$here/modules/$1" "${@:2}" >out.txt 2>err.txt || { cat err.txt; return 1; }
  [ ! -s err.txt ] || { cat err.txt; return 1; }
}
for module in QuenchMedialAxis QuenchTree QuenchThickness; do
  call "$module" --xml
  xmllint --noout --schema "$here/../../tests/cli/slicer_module.xsd" out.txt
done
call QuenchMedialAxis --volume root.nrrd --core core.vtp --skeleton skeleton.vtp --branches branches.csv
call QuenchTree --volume root.nrrd --kind root --centerlines lines.vtp --traits_table traits.csv
call QuenchThickness --volume root.nrrd --thickness thickness.nrrd --returnparameterfile back.params
test -s core.vtp -a -s skeleton.vtp -a -s branches.csv -a -s lines.vtp -a -s traits.csv -a -s thickness.nrrd
grep -q '^mean = ' back.params
if "$here/modules/QuenchTree" --volume none.nrrd --centerlines lines.vtp >out.txt 2>err.txt; then exit 1; fi
grep -q none.nrrd err.txt
echo "good"
