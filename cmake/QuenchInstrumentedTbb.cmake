# SPDX-License-Identifier: Apache-2.0
# Warns when TBB is not built with the thread sanitizer, which then takes all work it hands out for races.
get_target_property(tbb_library TBB::tbb IMPORTED_LOCATION_RELWITHDEBINFO)
if(NOT tbb_library)
  get_target_property(tbb_library TBB::tbb LOCATION)
endif()
execute_process(COMMAND ${CMAKE_NM} -D ${tbb_library} OUTPUT_VARIABLE symbols ERROR_QUIET)
if(NOT symbols MATCHES "__tsan_init")
  message(WARNING "${tbb_library} is not built with the thread sanitizer: there will be hundreds of false reports. "
                  "Run scripts/tsan-tbb and configure with --fresh.")
endif()
