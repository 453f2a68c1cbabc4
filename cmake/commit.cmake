# SPDX-License-Identifier: BSD-3-Clause
# Writes the commit of the sources into a C++ file, at every build, if it has changed:
# cmake -DSOURCE=... -DOUTPUT=... -P commit.cmake
set(commit unknown)
find_program(GIT git)
if(GIT)
  execute_process(COMMAND ${GIT} describe --always --dirty=-modified --abbrev=12 --exclude *
    WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(found)
    set(commit ${found})
  endif()
endif()
set(text "#include \"kestrel_slam/offline/provenance.h\"\n
const char* kestrel::builtCommit() { return \"${commit}\"; }\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
