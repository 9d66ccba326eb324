#!/bin/bash
# cluster_test.sh slurm|parallel MUSTER SCRIPTS: the jobs of a suite, run by Slurm (its own daemons, in a network
# namespace) or by GNU parallel, while jobs and a daemon are killed. Their rows are to be those of one machine.
set -euo pipefail

mode=$1 muster=$(realpath "$2") scripts=$(realpath "$3")
skip() { echo "SKIPPED: $1" && exit 77; }
if [[ $mode == slurm ]]; then
  for program in slurmctld slurmd munged sbatch; do
    command -v "$program" >/dev/null || skip "no $program (apt-get install slurm-wlm munge)"
  done
  ((UID == 0)) || skip "only root makes network namespaces"
  if [[ -z ${MUSTER_IN_NAMESPACE-} ]]; then MUSTER_IN_NAMESPACE=1 exec unshare --net "$0" "$@"; fi
else
  command -v parallel >/dev/null || skip "no parallel (apt-get install parallel)"
fi

work=$(mktemp -d)
daemons=()
# shellcheck disable=SC2317
leave() {
  local status=$?
  for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait
  if ((status && status != 77)); then
    tail -n 20 "$work"/*.log "$work"/*.out >&2 || true
  fi
  rm -rf "$work"
}
trap leave EXIT
chmod 755 "$work"
cd "$work"
ln -s "$muster" muster
export PATH=$work:$PATH

start_slurm() {
  local host
  host=$(hostname -s)
  ip link set lo up
  # Slurm looks for an address that is no loopback.
  ip addr add 10.99.0.1/32 dev lo
  mkdir state spool
  dd if=/dev/urandom of=munge.key bs=1024 count=1 status=none
  chmod 400 munge.key
  munged --force --foreground --key-file="$work/munge.key" --socket="$work/munge.sock" --pid-file="$work/munge.pid" \
    --log-file="$work/munge.log" --seed-file="$work/munge.seed" >munge.out 2>&1 &
  daemons+=($!)
  cat >slurm.conf <<CONF
ClusterName=test
SlurmctldHost=$host(10.99.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.sock
SlurmctldPort=17001
SlurmdPort=17002
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
SchedulerParameters=batch_sched_delay=1,sched_interval=2
NodeName=$host NodeAddr=10.99.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$work/slurm.conf
  slurmctld -D >slurmctld.out 2>&1 &
  daemons+=($!)
  slurmd -D >slurmd.out 2>&1 &
  slurmd=$!
  daemons+=("$slurmd")
  for ((i = 0; i < 120; ++i)); do
    sinfo --noheader --format %T 2>/dev/null | grep -q idle && return
    sleep 0.5
  done
  echo "Slurm has no idle node after a minute" >&2
  return 1
}

suite=(bench --suite paper --instances Random_1,Random_4 --methods mpq,horizon,kwta --availability strict --seeds 15)
muster "${suite[@]}" --jobs 1 --quiet --out whole
muster "${suite[@]}" --list-jobs --out part >jobs
(($(wc -l <jobs) == 6))

if [[ $mode == slurm ]]; then
  start_slurm
  "$scripts/slurm-jobs" jobs >run.out 2>&1 &
else
  parallel --retries 5 --joblog parallel.log --jobs 2 --sshlogin : --workdir "$work" <jobs >run.out 2>&1 &
fi
run=$!

# Jobs are killed in the midst of their runs, each at most twice: at the third time they are given up.
kills=0
declare -A times=()
for ((i = 0; i < 1200 && kills < 4; ++i)); do
  kill -0 $run 2>/dev/null || break
  for rows in part/*/runs.csv; do
    [[ -e $rows ]] && ((${times[$rows]-0} < 2)) || continue
    n=$(wc -l <"$rows") || continue
    ((n >= 4 && n < 14)) || continue
    victim=$(pgrep --full --oldest -- "--out ${rows%/runs.csv}\$") || continue
    kill -KILL "$victim" && kills=$((kills + 1)) times[$rows]=$((${times[$rows]-0} + 1))
  done
  if [[ $mode == slurm && $kills -ge 2 && -n ${slurmd-} ]]; then
    kill -KILL "$slurmd"
    slurmd -D >>slurmd.out 2>&1 &
    daemons+=($!)
    slurmd=
  fi
  sleep 0.05
done
wait $run
echo "$mode: $kills jobs were killed in their midst"
((kills >= 2))
muster "${suite[@]}" --merge part/* --out merged

# Without the last four columns, which are times.
rows() { sed -E 's/(,[^,]*){4}$//' "$1/runs.csv"; }
cmp <(rows whole) <(rows merged)
(($(rows merged | wc -l) == 451))
rm -r part/Random_4.kwta
if muster "${suite[@]}" --merge part/* --out again 2>error.out; then exit 1; fi
grep -q "run these jobs again: Random_4.kwta" error.out
