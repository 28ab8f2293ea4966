# Run after a test program is built: registers each of its suites as one test of CTest, named PROGRAM.SUITE. One
# process a suite instead of one a test, because loading the libraries takes longer than most tests, and what a
# suite sets up is set up once.
#   -D PROGRAM=file -D NAME=engine -D FILE=to be written -D TIMEOUT=s -D SLOWER=1 -D LABELS=unit
#   -D RULES=SUITE:PROPERTY=VALUE+...;...: of single suites -D RUNNER=command before the program
#   -D EMULATOR=of a program of another processor, and its arguments
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE list RESULT_VARIABLE failed TIMEOUT 60)
if(failed)
  message(FATAL_ERROR "${PROGRAM} cannot list its tests: ${failed}")
endif()
string(REGEX MATCHALL "(^|\n)[A-Za-z][A-Za-z0-9_/]*\\." suites "${list}")
if(NOT suites)
  message(FATAL_ERROR "${PROGRAM} holds no tests")
endif()
list(TRANSFORM suites REPLACE "[\n.]" "")
set(runner "")
foreach(word ${RUNNER})
  string(APPEND runner " \"${word}\"")
endforeach()

# What a rule says of a suite's property; a rule for a suite that is not there is a mistake.
foreach(rule ${RULES})
  string(REGEX REPLACE ":.*" "" suite "${rule}")
  if(NOT suite IN_LIST suites)
    message(FATAL_ERROR "${PROGRAM} has no suite ${suite}, for which there is a rule")
  endif()
  string(REGEX REPLACE "^[^:]*:" "" "rule_${suite}" "${rule}")
endforeach()

set(content "")
foreach(suite ${suites})
  set(seconds ${TIMEOUT})
  set(labels ${LABELS})
  set(more "")
  string(REPLACE "+" ";" changes "${rule_${suite}}")
  foreach(change ${changes})
    string(REGEX MATCH "^([A-Z_]+)=(.*)$" matched "${change}")
    if(CMAKE_MATCH_1 STREQUAL "TIMEOUT")
      set(seconds ${CMAKE_MATCH_2})
    elseif(CMAKE_MATCH_1 STREQUAL "LABELS")
      set(labels ${CMAKE_MATCH_2})
    else()
      string(APPEND more " ${CMAKE_MATCH_1} \"${CMAKE_MATCH_2}\"")
    endif()
  endforeach()
  math(EXPR seconds "${SLOWER} * ${seconds}")
  string(APPEND content "add_test(${NAME}.${suite}${runner} \"${PROGRAM}\" --gtest_filter=${suite}.*)\n"
    "set_tests_properties(${NAME}.${suite} PROPERTIES TIMEOUT ${seconds} LABELS ${labels}${more})\n")
endforeach()
file(WRITE ${FILE} "${content}")
