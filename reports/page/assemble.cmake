# Puts the page together when polhode is built: page.html with the files that it names in place of each /*@ NAME */, as
# one string of the program, so that a report needs nothing beside it.
#
#   cmake -DPAGE=reports/page -DLIBRARIES=FILE;FILE -DMISSING=PACKAGES -DOUTPUT=page_template.cpp -P assemble.cmake
#
# A file of LIBRARIES stands in for a NAME that page/ does not have; a library that is not installed is left out.
file(READ "${PAGE}/page.html" html)
string(REGEX MATCHALL "/\\*@ [a-z0-9_.]+ \\*/" marks "${html}")
foreach(mark IN LISTS marks)
  string(REGEX REPLACE "/\\*@ ([a-z0-9_.]+) \\*/" "\\1" name "${mark}")
  set(text "")
  foreach(file IN ITEMS "${PAGE}/${name}" ${LIBRARIES})
    get_filename_component(file_name "${file}" NAME)
    if(file_name STREQUAL name AND EXISTS "${file}")
      file(READ "${file}" text)
      break()
    endif()
  endforeach()
  if(text STREQUAL "" AND NOT name MATCHES "\\.min\\.js$")
    message(FATAL_ERROR "page.html names ${name}, which is not there")
  endif()
  string(FIND "${text}" "</script" ends_early)
  if(NOT ends_early EQUAL -1)
    message(FATAL_ERROR "${name} would end its own <script>")
  endif()
  string(REPLACE "${mark}" "${text}" html "${html}")
endforeach()
file(WRITE "${OUTPUT}" "// Written by reports/page/assemble.cmake.
#include \"reports/page.hpp\"

namespace polhode::report {
const std::string_view page_template = R\"polhode_page(${html})polhode_page\";
const std::string_view page_missing_packages = \"${MISSING}\";
}  // namespace polhode::report
")
