#!/usr/bin/env bash
# The real vantage-v4l2 on emulated devices, in a network of its own.
# usage: v4l2_process.sh BUILD_FOLDER [GTEST_OPTION...]
set -u -o pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
. "$root/tools/lib/network.sh"
enter_private_network "$0" "$@"
[ -n "${VANTAGE_PRIVATE_NETWORK:-}" ] || exit 77
export LCM_DEFAULT_URL="udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"
# Of its own, for what the processes leave there.
TMPDIR=$(mktemp -d)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
bin=$(cd "$1" && pwd)/bin
shift
"$bin/v4l2_process_test" "$@"
