# Run after a test program is built: registers each of its suites as one test of CTest, named PROGRAM.SUITE. One
# process a suite instead of one a test, because loading the libraries takes longer than most tests, and what a
# suite sets up is set up once.
#   -D PROGRAM=file -D NAME=field -D FILE=to be written -D TIMEOUT=s -D LABELS=... -D EMULATOR=program and its arguments
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE list RESULT_VARIABLE failed TIMEOUT 60)
if(failed)
  message(FATAL_ERROR "${PROGRAM} cannot list its tests: ${failed}")
endif()
string(REGEX MATCHALL "(^|\n)[A-Za-z][A-Za-z0-9_/]*\\." suites "${list}")
set(content "")
string(REPLACE ";" " " emulator "${EMULATOR}")
foreach(suite ${suites})
  string(REGEX REPLACE "[\n.]" "" suite ${suite})
  string(APPEND content "add_test(${NAME}.${suite} ${emulator} ${PROGRAM} --gtest_filter=${suite}.*)\n"
    "set_tests_properties(${NAME}.${suite} PROPERTIES TIMEOUT ${TIMEOUT} LABELS ${LABELS})\n")
endforeach()
if(content STREQUAL "")
  message(FATAL_ERROR "${PROGRAM} holds no tests")
endif()
file(WRITE ${FILE} "${content}")
