# Configures and builds. Sourced; needs $root.

# build_preset PRESET [TARGET...]: build/PRESET, all of it or the targets; prints only what matters.
build_preset() {
  local preset=$1
  shift
  local log=$root/build/$preset.log
  mkdir -p "$root/build"
  echo "Building (preset $preset; the whole output is in build/$preset.log)"
  local targets=()
  [ $# -gt 0 ] && targets=(--target "$@")
  if ! { cmake -S "$root" --preset "$preset" &&
         cmake --build "$root/build/$preset" "${targets[@]}"; } >"$log" 2>&1; then
    grep -E 'error|Error|FAILED' "$log" | head -n 20 >&2
    echo "the build failed; see build/$preset.log" >&2
    return 1
  fi
}
