#!/usr/bin/env bash
# What a user may get wrong: each gives one sentence that names the thing, exit code 2, and leaves
# nothing half-written.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"

failures=0

# refuses NAME PATTERN COMMAND...: exit code 2, one line on stderr that matches.
refuses() {
  local name=$1 pattern=$2 code
  shift 2
  timeout 20 "$@" >"$out/stdout" 2>"$out/stderr"
  code=$?
  if [ $code -ne 2 ]; then
    echo "FAILED: $name: exit code $code, expected 2: $(tail -n 3 "$out/stderr")"
    failures=$((failures + 1))
  elif ! grep -qE -- "$pattern" "$out/stderr"; then
    echo "FAILED: $name: \"$(cat "$out/stderr")\" does not match \"$pattern\""
    failures=$((failures + 1))
  elif [ "$(wc -l <"$out/stderr")" -gt 1 ]; then
    echo "FAILED: $name: more than one sentence: $(cat "$out/stderr")"
    failures=$((failures + 1))
  else
    echo "ok: $name: $(cat "$out/stderr")"
  fi
}

# absent NAME FILE: nothing may be left there.
absent() {
  if compgen -G "$2*" >/dev/null; then
    echo "FAILED: $1 left $(compgen -G "$2*")"
    failures=$((failures + 1))
  fi
}

# with_line PATTERN REPLACEMENT: a config with one line changed.
with_line() {
  write_config "$out/state"
  sed -i -e "s|$1|$2|" "$config"
}

for program in openni2 ppf fusion sim-arm; do
  run=("$bin/vantage-$program" --config "$config")
  refuses "no --config ($program)" "vantage-$program.*--config is required" "$bin/vantage-$program"
  refuses "unknown option ($program)" '--confg' "${run[@]}" --confg x
  refuses "config that is a folder ($program)" "$out is no file" "$bin/vantage-$program" --config "$out"
  with_line '^\[models\]' '[modles]'
  refuses "misspelt table ($program)" 'modles: unknown key; known here:.*models' "${run[@]}"
  with_line '^receive_buffer_bytes.*' 'receive_buffer_bytes = "big"'
  refuses "value of another type ($program)" "receive_buffer_bytes = 'big': expected a number" "${run[@]}"
  write_config "$out/state"
  refuses "bad name ($program)" "'a/b'.*expected 1 to 64" "${run[@]}" --name a/b
done

write_config "$out/state"
refuses "no config" 'is not there' "$bin/vantage-fusion" --config "$out/none.toml"
echo 'k = = 3' >"$out/broken.toml"
refuses "broken TOML" 'broken.toml:1:.*TOML' "$bin/vantage-fusion" --config "$out/broken.toml"
with_line '^sigma_deg' 'sigma_dge'
refuses "unknown key" 'fusion.sigma_dge.*unknown key' "$bin/vantage-fusion" --config "$config"
with_line '^\[fusion\]' '[fussion]'
refuses "unknown table" 'fussion.*unknown key' "$bin/vantage-ppf" --config "$config"
with_line '^k = 64' 'k = 1000'
refuses "out of range" 'fusion.k = 1000.*from 2 to 128' "$bin/vantage-fusion" --config "$config"
with_line '^sigma_deg.*' 'final_orientation = "mean"'
refuses "final orientation that is none" \
  '"voting" "vw_voting" "cw_clustering" "cw_vw_clustering" "density_mode"' "$bin/vantage-fusion" --config "$config"
# with_likely_pose MODEL QUATERNION SPREAD WEIGHT
with_likely_pose() {
  with_line '^\[planner\]' \
    "[[fusion.likely_pose]]\nmodel = \"$1\"\nq_world_object = $2\nspread_deg = $3\nweight = $4\n[planner]"
}
with_likely_pose teapot '[1, 0, 0, 0]' 5 1
refuses "likely pose of no model" 'likely_pose.0..model = .teapot.: expected one of .*bracket, filter, mug' \
  "$bin/vantage-fusion" --config "$config"
with_likely_pose mug '[0, 0, 0, 0]' 5 1
refuses "likely pose without a direction" 'likely_pose.0..q_world_object: .*norm 0' "$bin/vantage-fusion" --config "$config"
with_likely_pose mug '[1, 0, 0, 0]' 0 1
refuses "likely pose without spread" 'spread_deg = 0: expected a number from 0.1 to 30' "$bin/vantage-fusion" --config "$config"
with_likely_pose mug '[1, 0, 0, 0]' 5 0
refuses "likely poses without weight" 'weight = 0: expected more than 0 .*"mug"' "$bin/vantage-fusion" --config "$config"
with_line '"mug"' '"mugg"'
refuses "missing model" 'mugg' "$bin/vantage-ppf" --config "$config"
refuses "missing model" 'mugg' "$bin/vantage-fusion" --config "$config"
with_line '^folder = .*' "folder = \"$out/nowhere\""
refuses "missing models folder" 'nowhere' "$bin/vantage-ppf" --config "$config"
with_line '^device = .*' "device = \"oni:$out/none.oni\""
refuses "no recording" 'none.oni' "$bin/vantage-openni2" --config "$config"
with_line '^device = .*' 'device = "usb3"'
refuses "device that is none" 'camera.XTION.device = .usb3' "$bin/vantage-openni2" --config "$config"
with_line '^fps = .*' 'calibration = "none.toml"'
refuses "no calibration file" 'none.toml is not there' "$bin/vantage-openni2" --config "$config"
with_line '^elevation_deg = .*' 'elevation_deg = [70.0, 30.0]'
refuses "bounds in the wrong order" 'from 70 to 30.*lowest <= highest' "$bin/vantage-fusion" --config "$config"
with_line '^use = .*' 'use = ["../mug"]'
refuses "model that is a path" 'models.use.*"../mug"' "$bin/vantage-fusion" --config "$config"
with_line '^speed_m_per_s.*' 'speed_m_per_s = -1'
refuses "speed" 'speed_m_per_s = -1: expected a number from' "$bin/vantage-sim-arm" --config "$config"
with_line '^start_elevation_deg.*' 'start_elevation_deg = 5'
refuses "start out of reach" 'elevation 5.0 deg.*lowest 20.0' "$bin/vantage-sim-arm" --config "$config"
with_line '^model = "mug"' '#'
refuses "object without model" 'sim.object.1..model: missing' "$bin/vantage-sim-arm" --config "$config"
mkdir "$out/folder"
write_config "$out/folder"
refuses "state file that is a folder" 'folder is a folder.*expected' "$bin/vantage-fusion" --config "$config"
[ -d "$out/folder" ] && [ ! -e "$out/folder.bad" ] || { echo "FAILED: the folder was moved"; failures=1; }
write_config "$config/below/state"
refuses "state file below a file" "can't be made.*expected" "$bin/vantage-fusion" --config "$config"
with_line '^receive_buffer_bytes.*' 'receive_buffer_bytes = 8192'
refuses "receive buffer below its minimum" 'receive_buffer_bytes is 8192, expected 131072' \
  "$bin/vantage-fusion" --config "$config"
# Without the right to exceed it, the kernel grants net.core.rmem_max.
with_line '^receive_buffer_bytes.*' 'receive_buffer_bytes = 1073741824'
sed -i -e 's|^min_receive_buffer_bytes.*|min_receive_buffer_bytes = 1073741823|' "$config"
refuses "receive buffer of the URL below its minimum" 'recv_buf_size.*4194304, expected at least 10737' \
  "$bin/vantage-fusion" --config "$config"
refuses "receive buffer too small" 'grants a receive buffer of [0-9]+ bytes.*sysctl -w net.core.rmem_max=' \
  setpriv --bounding-set=-net_admin "$bin/vantage-fusion" --config "$config" --lcm-url udpm://
write_config "$out/state"
refuses "malformed URL" 'nonsense' "$bin/vantage-fusion" --config "$config" --lcm-url nonsense
refuses "no multicast route" 'ip route add 224.0.0.0/4 dev lo' \
  unshare -n "$bin/vantage-fusion" --config "$config"

start_fusion
for i in $(seq 50); do grep -q udpm "$out/log/fusion.log" 2>/dev/null && break; sleep 0.1; done
refuses "second process of a name" "fusion.*${stack_pid[fusion]}" "$bin/vantage-fusion" --config "$config"
stop_process fusion

head -c 5000 /dev/urandom >"$out/noise.lcm"
refuses "log that is none (replay)" 'noise.lcm' \
  "$bin/vantage-replay" "$out/noise.lcm" --config "$config" --output "$out/x.lcm"
absent "replay of noise" "$out/x.lcm"
refuses "log that is none (report)" 'noise.lcm' \
  "$bin/vantage-report" "$out/noise.lcm" --config "$config" --output "$out/x-report"
absent "report of noise" "$out/x-report"
refuses "log that is not there" 'none.lcm' "$bin/vantage-replay" "$out/none.lcm" --config "$config"
refuses "log that is not there" 'none.lcm' "$bin/vantage-log" info "$out/none.lcm"
: >"$out/empty.lcm"
refuses "empty log" 'empty.lcm' "$bin/vantage-replay" "$out/empty.lcm" --config "$config"
mkdir "$out/no-views"
refuses "folder without views" 'no-views' \
  "$bin/vantage-log" import "$out/no-views" --camera X --output "$out/y.lcm"
absent "import of nothing" "$out/y.lcm"
mkdir -p "$out/models/hollow"
cp "$root/models/mug/model.toml" "$out/models/hollow/"
with_line '^folder = .*' "folder = \"$out/models\""
sed -i -e 's|^use = .*|use = ["hollow"]|' "$config"
refuses "model folder without a mesh" 'hollow.*mesh.ply' "$bin/vantage-ppf" --config "$config"
refuses "mesh that is not there" 'none.ply' \
  "$bin/vantage-model" build "$out/none.ply" --unit m --output "$out/z"
absent "model of nothing" "$out/z"
printf 'ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n' \
  >"$out/void.ply"
refuses "empty mesh" 'void.ply' "$bin/vantage-model" build "$out/void.ply" --unit m --output "$out/z"
absent "model of an empty mesh" "$out/z"
printf 'v 0 0 0\nv 900 0 0\nv 0 900 0\nv 0 0 900\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$out/huge.obj"
refuses "mesh of a wrong unit" 'unit' "$bin/vantage-model" build "$out/huge.obj" --unit m --output "$out/z"
printf 'v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0.1 0.1 0\nf 1 2 3\nf 2 4 3\n' >"$out/flat.obj"
refuses "flat mesh" 'flat.obj' "$bin/vantage-model" build "$out/flat.obj" --unit m --output "$out/z"
printf 'v 0 0 nan\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$out/nan.obj"
refuses "mesh that is not finite" 'nan.obj' "$bin/vantage-model" build "$out/nan.obj" --unit m --output "$out/z"
absent "model of a bad mesh" "$out/z"

refuses "no table" 'none.bin: no such file' "$bin/vantage-contingency" show "$out/none.bin"
head -c 5000 /dev/urandom >"$out/noise.bin"
refuses "table that is none" 'noise.bin is not a contingency table' "$bin/vantage-contingency" show "$out/noise.bin"
refuses "merge with a table that is none" 'noise.bin' \
  "$bin/vantage-contingency" merge "$out/merged.bin" "$out/noise.bin"
absent "merge of noise" "$out/merged.bin"
refuses "trials of no model" 'no model folder' \
  "$bin/vantage-contingency" "$out/nowhere" --output "$out/table.bin"
refuses "estimator that is none" 'icp' \
  "$bin/vantage-contingency" "$root/models/mug" --estimator icp --output "$out/table.bin"
refuses "shard that is none" '--shard 3/2, expected I/N' \
  "$bin/vantage-contingency" "$root/models/mug" --shard 3/2 --output "$out/table.bin"
absent "trials of nothing" "$out/table.bin"
refuses "symmetry of a table that is none" 'noise.bin' \
  "$bin/vantage-model" symmetry "$root/models/mug" --table "$out/noise.bin"

# No device is no error: the driver says so and goes on searching.
write_config "$out/state"
start_process openni2 env -u VANTAGE_SIM_CONFIG LD_LIBRARY_PATH="$build/openni2" \
  "$bin/vantage-openni2" --config "$config"
wait_for 10 'no OpenNI2 device matches serial:SIM0001' "$out/log/openni2.log"
is_running openni2 || give_up "the driver ended without a device"
echo "ok: no device: $(grep 'no OpenNI2 device' "$out/log/openni2.log" | head -n 1)"

exit $((failures > 0))
