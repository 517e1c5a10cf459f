# Warnings as errors for a target of ours; other people's headers are included as SYSTEM.
function(vantage_set_warnings target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wold-style-cast -Werror)
  if(VANTAGE_SANITIZE)
    # GCC's documentation: sanitizers make this one report what is not so (in <regex>, for one).
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
  endif()
endfunction()
