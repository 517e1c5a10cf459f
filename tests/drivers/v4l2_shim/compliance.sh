#!/usr/bin/env bash
# v4l2-compliance, the kernel developers' own test of drivers, on an emulated device: what the shim
# does must be what drivers do. Exits with 77 where it is not installed (Debian package v4l-utils).
# usage: compliance.sh SHIM_LIBRARY
set -u -o pipefail
command -v v4l2-compliance >/dev/null || exit 77
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cat >"$out/devices" <<DEVICE
device 0
serial CAM0
speed 10
format YUYV 64x48 30 15
format UYVY 64x48 30
format GREY 64x48 30
format GRBG 64x48 30
format MJPG 64x48 30
format Z16 64x48 30 60
format Y10B 64x48 30
control brightness 0 255 1 128
control gain 0 100 5 10
control power_line_frequency 0 2 1 1
DEVICE
LD_PRELOAD=$1 VANTAGE_V4L2_SHIM=$out/devices \
  timeout 60 v4l2-compliance -d /dev/video0 -s5 >"$out/report" 2>&1
# The shim has no priorities of openers and no events.
failed=$(grep ': FAIL$' "$out/report" | grep -vE 'G/S_PRIORITY|SUBSCRIBE_EVENT')
passed=$(sed -n 's/^Total .* Succeeded: \([0-9]*\),.*/\1/p' "$out/report")
if [ -n "$failed" ] || [ "${passed:-0}" -lt 50 ]; then
  cat "$out/report"
  exit 1
fi
echo "ok: $passed checks"
