# Uses ccache where it is installed.
find_program(VANTAGE_CCACHE ccache)
if(VANTAGE_CCACHE)
  set(CMAKE_C_COMPILER_LAUNCHER ${VANTAGE_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${VANTAGE_CCACHE})
endif()
