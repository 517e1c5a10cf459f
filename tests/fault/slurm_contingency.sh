#!/usr/bin/env bash
# A contingency table on a Slurm cluster of two nodes, all of it on this machine and private to the
# test. One node is killed with the task on it: the task is queued again and the table is still the
# one that a single process makes. Exits with 77 where Slurm is not installed.
# usage: slurm_contingency.sh BUILD_FOLDER
set -u -o pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$(realpath "${1:?usage: slurm_contingency.sh BUILD_FOLDER}")
export PATH=$PATH:/usr/sbin
export VANTAGE_CONTINGENCY=$build/bin/vantage-contingency

for program in munged slurmctld slurmd sbatch; do
  command -v $program >/dev/null || {
    echo "skipped: $program is not installed (Debian packages slurm-wlm and munge)"
    exit 77
  }
done

out=$(mktemp -d /tmp/vantage-slurm.XXXXXX)
chmod 755 "$out"
export SLURM_CONF=$out/slurm.conf

# with_environment [TEXT]: ids of this cluster's processes that have it in their environment.
with_environment() {
  local files
  files=$(grep -lszFx -e "SLURM_CONF=$SLURM_CONF" /proc/[0-9]*/environ)
  [ -n "$files" ] && [ $# -gt 0 ] && files=$(grep -lszFx -e "$1" $files)
  echo "$files" | tr -dc '0-9\n'
}

end() {
  local ids
  ids=$(with_environment)
  [ -n "$ids" ] && kill -KILL $ids 2>/dev/null
  rm -rf "$out"
}
trap end EXIT

give_up() {
  echo "FAILED: $1" >&2
  tail -n 15 "$out"/*.log "$out"/t.bin*/*.log >&2 2>/dev/null
  [ -e "$SLURM_CONF" ] && timeout 5 squeue -a >&2
  exit 1
}

# wait_until SECONDS COMMAND...
wait_until() {
  local tries=$(($1 * 10))
  shift
  for _ in $(seq $tries); do
    "$@" && return 0
    sleep 0.1
  done
  return 1
}

# Ports that nobody listens at, from a place that depends on the process.
free_port() {
  while ss -Hltn "sport = :$port" | grep -q .; do port=$((port + 1)); done
  echo $port
  port=$((port + 1))
}
port=$((20000 + $$ % 20000))

write_cluster() {
  local control one two me host
  control=$(free_port) && port=$((control + 1))
  one=$(free_port) && port=$((one + 1))
  two=$(free_port)
  me=$(id -un)
  host=$(hostname -s)
  mkdir -p "$out/state" "$out/one" "$out/two" "$out/munge"
  chmod 711 "$out/munge"
  head -c 1024 /dev/urandom >"$out/munge/key"
  chmod 600 "$out/munge/key"
  cat >"$SLURM_CONF" <<CONF
ClusterName=vantage
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$me
SlurmdUser=$me
SlurmctldPort=$control
AuthType=auth/munge
AuthInfo=socket=$out/munge/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$out/state
SlurmdSpoolDir=$out/%n
SlurmctldPidFile=$out/slurmctld.pid
SlurmdPidFile=$out/%n.pid
SlurmctldLogFile=$out/slurmctld.log
SlurmdLogFile=$out/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SlurmdTimeout=4
MessageTimeout=2
TCPTimeout=1
SlurmctldTimeout=10
InactiveLimit=0
KillWait=1
MinJobAge=300
SchedulerParameters=sched_interval=1,bf_interval=1
SchedulerType=sched/builtin
JobRequeue=1
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=$one CPUs=1
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=$two CPUs=1
PartitionName=all Nodes=ALL Default=YES State=UP MaxTime=INFINITE
CONF
}

start_cluster() {
  munged --force --foreground --socket="$out/munge/socket" --key-file="$out/munge/key" \
    --pid-file="$out/munge/pid" --log-file="$out/munge/log" --seed-file="$out/munge/seed" \
    >"$out/munged.log" 2>&1 &
  wait_until 10 test -S "$out/munge/socket" || give_up "munged did not start"
  slurmctld -D -i >"$out/slurmctld.out.log" 2>&1 &
  for node in one two; do
    VANTAGE_SLURM_NODE=$node slurmd -D -N $node >"$out/$node.out.log" 2>&1 &
  done
  wait_until 30 has_nodes 2 || give_up "the nodes did not come up: $(sinfo -N 2>&1)"
}

has_nodes() { [ "$(sinfo -hN -t idle,alloc,mix 2>/dev/null | wc -l)" -eq "$1" ]; }

# task_on_node_one: a task runs there and has finished part of its trials.
task_on_node_one() {
  task=$(squeue -hr -t R -w one -o %K 2>/dev/null | head -n 1)
  [ -n "$task" ] && grep -qs '^direction' "$out/t.bin.parts/$task.trials"
}

# All of a node ends at once: its daemon, the task's supervisor, which must not tell of the task's
# end, and the task.
kill_node_one() {
  local job parent ids
  ids=$(with_environment VANTAGE_SLURM_NODE=one)
  for job in $(with_environment SLURMD_NODENAME=one); do
    parent=$(awk '/^PPid:/ { print $2 }' "/proc/$job/status")
    grep -q '^slurmstepd' "/proc/$parent/cmdline" && ids="$ids $parent"
    ids="$ids $job"
  done
  kill -KILL $ids
}

work=(hub --directions 48 --trials 60)
"$VANTAGE_CONTINGENCY" measure "${work[@]}" --threads 2 --output "$out/single.bin" 2>"$out/single.log" ||
  give_up "the single process"
write_cluster
start_cluster
jobs=$("$root/tools/slurm/submit_contingency" hub 6 "$out/t.bin" -- "${work[@]:1}") ||
  give_up "submit_contingency"
read -r array merge <<<"$jobs"
echo "submitted the array $array and the merge $merge"

wait_until 30 task_on_node_one || give_up "no task on node one"
kill_node_one
echo "killed node one with task $task"
[ -e "$out/t.bin.parts/$task" ] && give_up "task $task had ended before: nothing is tested"
requeued() {
  scontrol -o show job "${array}_$task" 2>/dev/null | grep -q ' Restarts=[1-9]'
}
wait_until 40 requeued || give_up "task $task was not queued again"
echo "task $task is queued again"
wait_until 60 test -s "$out/t.bin" || give_up "no merged table"
cmp "$out/t.bin" "$out/single.bin" || give_up "the merged table differs"
scontrol -o show job "${array}_$task" | grep -q 'BatchHost=two' || give_up "task $task did not run on node two"
echo "ok: the table of 6 shards on 2 nodes, one of which died, is that of one process"
