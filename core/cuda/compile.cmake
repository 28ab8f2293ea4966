# Compiles one .cu file; what ptxas says of its kernels is kept for check_resources.cmake.
#   -D NVCC=... -D FLAGS=a;b -D SOURCE=... -D OBJECT=... -D LOG=... -D DEPENDENCIES=...
execute_process(COMMAND ${NVCC} ${FLAGS} -Xptxas -v -MMD -MF ${DEPENDENCIES} -MT ${OBJECT} -c ${SOURCE} -o ${OBJECT}
  OUTPUT_VARIABLE said ERROR_VARIABLE said RESULT_VARIABLE failed)
file(WRITE ${LOG} "${said}")
if(failed)
  message(FATAL_ERROR "${said}")
endif()
string(REGEX MATCHALL "[^\n]*(warning|error)[^\n]*" warnings "${said}")
foreach(line ${warnings})
  message(NOTICE "${line}")
endforeach()
