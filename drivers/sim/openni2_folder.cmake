# OpenNI2 looks for plugins in OpenNI2/Drivers beside the libOpenNI2.so.0 that was loaded, and
# nowhere else. So a folder of our own holds a link to that library, links to the stock plugins and
# our plugin; put first on LD_LIBRARY_PATH it replaces the system's, without root.
#
#   vantage_openni2_plugin(TARGET FOLDER [EXPORTS file])
#
# Makes the module library TARGET the plugin FOLDER/OpenNI2/Drivers/libTARGET.so.0. It lives in one
# process with programs that hold the same static libraries, so it shows only the symbols that
# the linker's version script EXPORTS names.
function(vantage_openni2_plugin target folder)
  cmake_parse_arguments(ARG "" "EXPORTS" "" ${ARGN})
  if(NOT ARG_EXPORTS)
    set(ARG_EXPORTS ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/openni2_plugin.map)
  endif()
  find_library(OPENNI2_LIBRARY OpenNI2 REQUIRED)
  file(REAL_PATH ${OPENNI2_LIBRARY} library)
  cmake_path(GET library PARENT_PATH library_folder)
  file(MAKE_DIRECTORY ${folder}/OpenNI2/Drivers)
  file(CREATE_LINK ${library} ${folder}/libOpenNI2.so.0 SYMBOLIC)
  file(GLOB stock_plugins ${library_folder}/OpenNI2/Drivers/lib*.so.0)
  foreach(plugin IN LISTS stock_plugins)
    cmake_path(GET plugin FILENAME name)
    # The dummy would be a second device that delivers test patterns.
    if(NOT name STREQUAL "libDummyDevice.so.0")
      file(CREATE_LINK ${plugin} ${folder}/OpenNI2/Drivers/${name} SYMBOLIC)
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES
    LIBRARY_OUTPUT_DIRECTORY ${folder}/OpenNI2/Drivers
    PREFIX lib
    SUFFIX .so.0
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    LINK_DEPENDS ${ARG_EXPORTS})
  target_link_options(${target} PRIVATE
    -Wl,--version-script,${ARG_EXPORTS} -Wl,--exclude-libs,ALL -Wl,--as-needed)
endfunction()
