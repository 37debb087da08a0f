# Writes OUT, the definition of program_version(), for the source TREE of project VERSION. GIT is the program, empty when there is none.
set(commit unknown)
if(GIT)
  # "dubious ownership" is about running hooks of a foreign tree; the tree that is being built is trusted already.
  get_filename_component(real_tree ${TREE} REALPATH)
  set(git ${GIT} -c safe.directory=${real_tree} --no-optional-locks -C ${real_tree})
  execute_process(COMMAND ${git} rev-parse --show-toplevel OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND ${git} rev-parse --verify HEAD OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  get_filename_component(real_top "${top}" REALPATH)
  # An unpacked archive inside the tree of another project has no history of its own.
  if(real_top STREQUAL real_tree AND head MATCHES "^[0-9a-f]+$")
    string(SUBSTRING ${head} 0 12 commit)
    execute_process(COMMAND ${git} status --porcelain OUTPUT_VARIABLE changes RESULT_VARIABLE failed ERROR_QUIET)
    if(failed OR NOT changes STREQUAL "")
      string(APPEND commit .modified)
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[// Written by deploy/cmake/write_program_version.cmake.
#include "control/contract/program_version.hpp"

namespace hoist::contract {

std::string_view program_version() { return "@VERSION@+@commit@"; }

}  // namespace hoist::contract
]])
