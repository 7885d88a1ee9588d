#!/bin/bash
# A Slurm cluster of one node for the tests: private, on the loopback, without cgroups and accounting; nothing of the
# machine's own configuration is read or changed. As root: munged runs as user munge, as it wants to.
#   slurm.sh up FOLDER [PID]  starts it and prints the line that makes a shell use it; ends it when process PID ends
#   slurm.sh kill FOLDER    kills the controller with -9
#   slurm.sh again FOLDER   starts the controller again, and takes the node back into service as an operator would
#   slurm.sh down FOLDER    ends it, and removes the folder
set -euo pipefail
[ $# -ge 2 ] || { sed -n '2,7s/^# //p' "$0" >&2; exit 2; }
for program in munged slurmctld slurmd sbatch; do
    command -v $program >/dev/null || [ -x /usr/sbin/$program ] || {
        echo "$program is missing: apt-get install slurm-wlm munge" >&2; exit 1; }
done
mkdir -p "$2"
at=$(realpath "$2")
export PATH="$PATH:/usr/sbin" SLURM_CONF="$at/slurm.conf"
cores=$(nproc)

free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

configure() {
    mkdir -p "$at"/{state,spool,log,run,munge}
    # Slurm wants no folder above its key that others may write to.
    chmod 755 "$at" "$at/munge"
    head -c 1024 /dev/urandom >"$at/munge/munge.key"
    chmod 400 "$at/munge/munge.key"
    [ "$(id -u)" = 0 ] && chown -R munge:munge "$at/munge"
    cat >"$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=localhost
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$at/munge/socket
CredType=cred/munge
StateSaveLocation=$at/state
SlurmdSpoolDir=$at/spool
SlurmctldPidFile=$at/run/slurmctld.pid
SlurmdPidFile=$at/run/slurmd.pid
SlurmctldLogFile=$at/log/slurmctld.log
SlurmdLogFile=$at/log/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=1,default_queue_depth=10000
ReturnToService=2
SlurmdParameters=config_overrides
MinJobAge=300
KillWait=2
SlurmdTimeout=15
MessageTimeout=30
NodeName=localhost CPUs=$((2 * cores)) RealMemory=64000 State=UNKNOWN
PartitionName=debug Nodes=localhost Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
END
}

controller() {
    # Detached: the test that starts it may be killed, and this script ends.
    setsid slurmctld -D "$@" >"$at/log/slurmctld.out" 2>&1 </dev/null &
    echo $! >"$at/run/slurmctld.started"
}

wait_until() {
    local end=$((SECONDS + 120))
    while [ $SECONDS -lt $end ]; do "$@" >/dev/null 2>&1 && return; sleep 0.1; done
    echo "Slurm did not come up:" >&2
    tail -n 20 "$at"/log/* >&2
    return 1
}

# A `*` after its state means that the node does not answer yet.
is_ready() { timeout 10 sinfo -h -o %T | grep -qxE 'idle|mixed|allocated'; }

# A controller that died before it saved its state hands out job numbers a second time; slurmd refuses one that it still runs a job
# of, and the controller then drains the node ("Duplicate jobid"), at the first such job, which may be a while after the start: until
# the cluster ends, somebody watches.
operator() {
    while [ -e "$at/run/operated" ]; do
        if [ -n "$(timeout 10 sinfo -h -R -o %E 2>/dev/null)" ]; then
            timeout 10 scontrol update nodename=localhost state=resume >>"$at/log/operator.out" 2>&1 || true
        fi
        sleep 1
    done
}

again() {
    controller
    if [ ! -e "$at/run/operated" ]; then
        touch "$at/run/operated"
        operator >/dev/null 2>&1 </dev/null &
    fi
    wait_until is_ready
}

up() {
    configure
    local munged="munged --foreground --key-file=$at/munge/munge.key --socket=$at/munge/socket --seed-file=$at/munge/seed"
    munged+=" --pid-file=$at/munge/pid --log-file=$at/munge/log"
    if [ "$(id -u)" = 0 ]; then munged="setpriv --reuid=munge --regid=munge --clear-groups $munged"; fi
    setsid $munged >"$at/log/munged.out" 2>&1 </dev/null &
    echo $! >"$at/run/munged.started"
    wait_until munge -S "$at/munge/socket" -n
    controller -i
    setsid slurmd -D -N localhost >"$at/log/slurmd.out" 2>&1 </dev/null &
    echo $! >"$at/run/slurmd.started"
    wait_until is_ready
    if [ $# = 1 ]; then
        setsid bash -c "while kill -0 $1; do sleep 1; done; exec bash '$0' down '$at'" >/dev/null 2>&1 </dev/null &
    fi
    echo "export SLURM_CONF=$SLURM_CONF"
}

down() {
    # Running jobs first, or the daemons of their steps outlive the cluster.
    rm -f "$at/run/operated"
    timeout 10 scancel --user="$(id -un)" 2>/dev/null || true
    for _ in $(seq 50); do [ -z "$(timeout 5 squeue -h 2>/dev/null)" ] && break; sleep 0.1; done
    for name in slurmd slurmctld munged; do
        local pid
        pid=$(cat "$at/run/$name.started" 2>/dev/null) || continue
        kill "$pid" 2>/dev/null || true
        for _ in $(seq 50); do kill -0 "$pid" 2>/dev/null || break; sleep 0.1; done
        kill -9 "$pid" 2>/dev/null || true
    done
    rm -rf "$at"
}

case $1 in
up) up "${@:3}" ;;
kill) kill -9 "$(cat "$at/run/slurmctld.started")" ;;
again) again ;;
down) down ;;
*) echo "$0: unknown: $1" >&2; exit 2 ;;
esac
