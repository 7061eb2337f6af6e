# SPDX-License-Identifier: Apache-2.0
# -DQUENCH_PYTHON=ON: an error without pybind11; AUTO: built where it is found. Debian's interpreter is taken, whose
# packages are the ones installed by scripts/install-deps, unless -DPython3_EXECUTABLE names another.
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python3 3.9 QUIET COMPONENTS Interpreter Development.Module)
set(QUENCH_WITH_PYTHON OFF)
if(Python3_Interpreter_FOUND AND Python3_Development.Module_FOUND)
  set(PYTHON_EXECUTABLE ${Python3_EXECUTABLE})  # what pybind11 2.10 looks at
  set(PYBIND11_FINDPYTHON OFF)
  find_package(pybind11 2.9 QUIET CONFIG)
  if(pybind11_FOUND)
    set(QUENCH_WITH_PYTHON ON)
  endif()
endif()
if(NOT QUENCH_WITH_PYTHON)
  set(QUENCH_NO_PYTHON "the Python module needs pybind11 (pybind11-dev) and the headers of Python 3.9 or later (python3-dev)")
  if(QUENCH_PYTHON STREQUAL "AUTO")
    message(STATUS "Python module: not built; ${QUENCH_NO_PYTHON}")
  else()
    message(FATAL_ERROR "QUENCH_PYTHON=${QUENCH_PYTHON}: ${QUENCH_NO_PYTHON}")
  endif()
endif()
