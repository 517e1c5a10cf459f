# VANTAGE_SANITIZE: a list for -fsanitize, e.g. "address,undefined".
set(VANTAGE_SANITIZE "" CACHE STRING "Sanitizers to build with")
if(VANTAGE_SANITIZE)
  add_compile_options(-fsanitize=${VANTAGE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${VANTAGE_SANITIZE})
endif()
