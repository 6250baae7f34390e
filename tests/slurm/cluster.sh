#!/usr/bin/env bash
# cluster.sh FOLDER NODES
# A private Slurm on this machine's loopback, all of it in FOLDER: munge, a controller, and NODES
# nodes of two processors, and of a GPU that only Slurm believes in. Says "up" when all are idle, and
# takes everything down when its standard input ends, as it does when whoever started this is killed.
# SLURM_CONF=FOLDER/slurm.conf leads Slurm's commands there. Needs slurm-wlm and munge; any user.
set -euo pipefail

folder=$(realpath -m -- "$1")
nodes=$2
PATH=$PATH:/usr/sbin
export SLURM_CONF=$folder/slurm.conf

free_ports() { # N
  /usr/bin/python3 - "$1" <<'PYTHON'
import random, socket, sys
held = []
while len(held) < int(sys.argv[1]):  # below those that outgoing connections get
    try:
        held.append(socket.create_server(("127.0.0.1", random.randrange(12000, 32000))))
    except OSError:
        pass
print(*(one.getsockname()[1] for one in held))
PYTHON
}

configure() {
  local user ports node
  user=$(id -un)
  read -ra ports < <(free_ports $((nodes + 1)))
  mkdir -p "$folder"/{state,spool,log,munge}
  head -c 128 /dev/urandom >"$folder/munge/key"
  chmod 600 "$folder/munge/key"
  # cred_expire is also what a requeued job waits before it starts again; less is refused.
  # Where no cgroup file system is mounted, slurmd 22.05 wants to hear a plugin's name all the same.
  echo "CgroupPlugin=cgroup/v1" >"$folder/cgroup.conf"
  echo "Name=gpu File=/dev/null" >"$folder/gres.conf"
  cat >"$SLURM_CONF" <<CONF
ClusterName=private
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket,cred_expire=5
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd-%n.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/slurmd-%n.log
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1
SlurmdParameters=config_overrides
SlurmdTimeout=3
MessageTimeout=3
InactiveLimit=0
KillWait=5
MinJobAge=300
GresTypes=gpu
MaxArraySize=5
ReturnToService=2
JobRequeue=1
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  for ((node = 0; node < nodes; ++node)); do
    mkdir -p "$folder/spool/n$node"
    echo "NodeName=n$node NodeHostname=localhost NodeAddr=127.0.0.1 Port=${ports[node + 1]}" \
      "CPUs=2 RealMemory=1000 Gres=gpu:1" >>"$SLURM_CONF"
  done
}

start() {
  local node
  # --force: the private folder may lie under one that only its owner can enter.
  munged -F --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" \
    --seed-file="$folder/munge/seed" >"$folder/log/munged.out" 2>&1 </dev/null &
  for _ in {1..200}; do
    [ -S "$folder/munge/socket" ] && break
    sleep 0.02
  done
  slurmctld -D >"$folder/log/ctld.out" 2>&1 </dev/null &
  for ((node = 0; node < nodes; ++node)); do
    slurmd -D -N "n$node" >"$folder/log/n$node.out" 2>&1 </dev/null &
  done
  disown -a  # no word about each when they are killed
}

all_idle() { [ "$(sinfo -h -N -o %T 2>/dev/null | grep -c '^idle$')" = "$nodes" ]; }

wait_until_idle() {
  for _ in {1..200}; do
    all_idle && return
    sleep 0.05
  done
  return 1
}

# Daemons, job steps (which outlive the daemon that started them) and what jobs run: all have this
# variable, with a path that no other process has.
ours() (
  mark=SLURM_CONF=$SLURM_CONF
  unset SLURM_CONF
  grep -lzsxF "$mark" /proc/[0-9]*/environ | cut -d/ -f3
)

take_down() {
  local processes
  for _ in {1..100}; do
    mapfile -t processes < <(ours)
    [ ${#processes[@]} -eq 0 ] && return
    kill -KILL "${processes[@]}" 2>/dev/null || true
    sleep 0.02
  done
  echo "cluster.sh: could not end ${processes[*]}" >&2
}
trap take_down EXIT
trap 'exit 143' TERM INT HUP

up=no
for _ in 1 2 3; do # somebody else may have taken a port meanwhile
  configure
  start
  wait_until_idle && { up=yes; break; }
  take_down
done
if [ $up = no ]; then
  tail -n 5 "$folder"/log/* >&2
  exit 1
fi
echo up
cat <&0 >/dev/null & # `wait` ends at once where a signal comes
wait $!
