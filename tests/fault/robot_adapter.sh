#!/usr/bin/env bash
# The example adapters, in C++ and Python: each keeps the message contract, and leads the simulated set-up
# to its end in the place of vantage-sim-arm.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"

export PYTHONPATH=$build/share/python
python3 -c 'import lcm' 2>/dev/null || PYTHONPATH+=:$root/tests/examples/lcm_stand_in
export PYTHONDONTWRITEBYTECODE=1
declare -A adapter=(
  [C++]="$bin/robot-adapter"
  [Python]="python3 $root/examples/robot_adapter/robot_adapter.py"
)

start_adapter() {
  local command
  read -ra command <<<"${adapter[$1]}"
  start_process "adapter-$1" "${command[@]}"
}

for language in C++ Python; do
  echo "The adapter in $language"
  start_adapter $language
  timeout 200 python3 "$root/tests/examples/adapter_contract.py" >"$out/progress.txt" 2>&1 ||
    give_up "the adapter in $language breaks the contract: $(tail -n 1 "$out/progress.txt")"
  is_running "adapter-$language" || give_up "the adapter in $language has ended by itself"
  stop_process "adapter-$language"

  write_config "$out/state-$language"
  sed -i 's/^max_views = .*/max_views = 4/' "$config"
  start_adapter $language
  start_camera
  start_estimator
  start_fusion
  "$bin/vantage-progress" --config "$config" --timeout 120 --until-finished >"$out/progress.txt" 2>&1 ||
    give_up "the run with the adapter in $language did not end"
  grep -q '^view 4' "$out/progress.txt" || give_up "the adapter in $language did not go through four views"
  stop_stack
  echo "ok: $(grep '^finished' "$out/progress.txt")"
done
for file in "$root"/examples/robot_adapter/robot_adapter.{cc,py}; do
  [ "$(wc -l <"$file")" -le 30 ] || give_up "$file has more than 30 lines"
done
