#!/usr/bin/env bash
# A simulated robot calibrates its camera, the result is used, and a knock of the camera is noticed.
set -u -o pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
. "$root/tools/lib/network.sh"
enter_private_network "$0" "$@"
[ -n "${VANTAGE_PRIVATE_NETWORK:-}" ] || exit 77
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
VANTAGE_BUILD=$(cd "$1" && pwd) "$root/tools/calibrate-demo" --output "$out"
