# SPDX-License-Identifier: Apache-2.0
"""The core in tasks through real schedulers, those of examples/cluster, and by real processes of MPI; tasks are killed
in the middle, repeated, and started twice at the same time. In all cases the file is that of `quench core`.

Run as root by `make test-cluster`, inside tests/cluster/slurm_here. QUENCH_BUILD: folder of quench and quench-mpi.
Waiting for a scheduler means asking it again and again: no test depends on how long that takes.
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / 'examples' / 'cluster'
BUILD = pathlib.Path(os.environ.get('QUENCH_BUILD', ROOT / 'build' / 'release')).resolve()
PLAN = ['torus.ply', '--resolution', '128', '--size', '24']  # 3 rounds
ENVIRONMENT = {**os.environ, 'PATH': f"{BUILD}:/usr/bin:{os.environ['PATH']}", 'TASK_CPUS': '1', 'TASK_MEMORY': '1G 2G',
               'MERGE_MEMORY': '2G', 'OMPI_MCA_btl_vader_single_copy_mechanism': 'none'}
# In place of quench: `bricks run` waits while there is a file `hold` where it runs; the first ones that find a file
# `kill-...` there are killed soon after their start.
IN_PLACE = f"""#!/bin/bash
if [ "$1 $2" = 'bricks run' ]; then
  [ ! -e hold ] || : >held
  while [ -e hold ]; do sleep 0.02; done
  for file in kill-*; do
    mv "$file" "done-$file" 2>/dev/null || continue
    timeout -s KILL 0.05 '{BUILD}/quench' "$@"
    kill -KILL $$
  done
fi
exec '{BUILD}/quench' "$@"
"""


def run(command, cwd, code=0, **more):
    done = subprocess.run([str(word) for word in command], cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True,
                          check=False, **more)
    assert done.returncode == code, f'{command} ended with {done.returncode}\n{done.stdout}\n{done.stderr}'
    return done


def wait_for(condition, what):
    """Asks until it is true; what it answers."""
    for _ in range(30000):
        if found := condition():
            return found
        time.sleep(0.02)
    raise AssertionError(f'{what} does not happen')


@pytest.fixture(scope='session')
def whole(tmp_path_factory):
    """The shape, and its core in one piece."""
    folder = tmp_path_factory.mktemp('whole')
    (folder / 'quench').write_text(IN_PLACE)
    (folder / 'quench').chmod(0o755)
    ENVIRONMENT['PATH'] = f"{folder}:{ENVIRONMENT['PATH']}"
    run(['quench', 'sample', 'torus', '-o', 'torus.ply', '--quiet'], folder)
    run(['quench', 'core', *PLAN[:3], '-o', 'core.vtp', '--quiet'], folder)
    return folder


@pytest.fixture
def here(whole, tmp_path):
    """A folder with the shape, whose name has what shells take apart."""
    folder = tmp_path / "a folder's name"
    folder.mkdir()
    os.link(whole / 'torus.ply', folder / 'torus.ply')
    return folder


def expect_core(whole, file):
    assert file.read_bytes() == (whole / 'core.vtp').read_bytes()


def kill_programs(folder, count):
    """So many of the tasks that are to come."""
    for i in range(count):
        (folder / f'kill-{i}').touch()


def expect_killed(folder, count):
    assert len(list(folder.glob('done-kill-*'))) == count


def status(folder, work='work'):
    return json.loads(run(['quench', 'bricks', 'status', work, '--json'], folder).stdout)


# -------------------------------------------------------------------------------------------------------- one machine

def test_one_machine_interrupted_and_run_again(whole, here):
    command = [EXAMPLES / 'one_machine.sh', 'work', 'core.vtp', '2', *PLAN]
    with subprocess.Popen(['bash', *map(str, command)], cwd=here, env=ENVIRONMENT, stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, start_new_session=True) as first:
        wait_for(lambda: list(here.glob('work/round-1/*.part')), 'a brick')
        os.killpg(first.pid, signal.SIGKILL)
    assert not (here / 'core.vtp').exists()
    assert status(here)['rounds'][-1]['done'] < status(here)['rounds'][-1]['bricks']
    run(['bash', *command], here)
    expect_core(whole, here / 'core.vtp')


# -------------------------------------------------------------------------------------------------------------- SLURM

def jobs(*states):
    """Those of the queue, with their tasks one by one."""
    wanted = ['-t', ','.join(states)] if states else []
    return subprocess.run(['squeue', '-h', '-r', '-o', '%i', *wanted], capture_output=True, text=True,
                          check=True).stdout.split()


def submit(folder, *words, core='core.vtp'):
    """Runs slurm.sh; the numbers of its jobs."""
    told = run(['bash', EXAMPLES / 'slurm.sh', 'work', core, '6', *words], folder).stdout
    return re.findall(r'job (\d+)', told)


def wait_for_queue():
    wait_for(lambda: not jobs(), 'the end of all jobs')


def log_of(folder):
    return {file.name: file.read_text() for file in (folder / 'work' / 'log').iterdir()}


def test_slurm_on_two_nodes(whole, here):
    submit(here, *PLAN)
    wait_for_queue()
    expect_core(whole, here / 'core.vtp')
    nodes = set(re.findall(r'^job \d+ on (\w+)$', '\n'.join(log_of(here).values()), re.M))
    assert nodes == {'here', 'there'}


def test_slurm_goes_on_by_itself_when_programs_are_killed_and_tasks_requeued(whole, here):
    kill_programs(here, 2)
    (here / 'hold').touch()
    submit(here, *PLAN)
    wait_for((here / 'held').exists, 'a task at work')
    subprocess.run(['scontrol', 'requeue', jobs('RUNNING')[0]], check=True)
    (here / 'hold').unlink()
    wait_for_queue()
    expect_core(whole, here / 'core.vtp')
    expect_killed(here, 2)
    assert sum(text.count('Killed') for text in log_of(here).values()) >= 2


def test_slurm_tasks_killed_for_good_are_done_when_submitted_again(whole, here):
    (here / 'hold').touch()
    rounds = submit(here, *PLAN)[:-1]
    wait_for((here / 'held').exists, 'a task at work')
    run(['scancel', '--signal=KILL', '--full', jobs('RUNNING')[0]], here)
    (here / 'hold').unlink()
    run(['scancel', *rounds], here)
    wait_for_queue()  # the merge, which depends on them, goes, too
    assert not (here / 'core.vtp').exists()
    submit(here)
    wait_for_queue()
    expect_core(whole, here / 'core.vtp')


def test_slurm_tasks_twice_at_the_same_time(whole, here):
    run(['quench', 'bricks', 'plan', *PLAN, '-o', 'work'], here)
    submit(here, core='one.vtp')
    submit(here, core='other.vtp')
    wait_for_queue()
    expect_core(whole, here / 'one.vtp')
    expect_core(whole, here / 'other.vtp')


def test_slurm_says_why_there_is_no_plan(here):
    failed = run(['bash', EXAMPLES / 'slurm.sh', 'work', 'core.vtp', '6', 'no.ply'], here, code=1)
    assert "'no.ply'" in failed.stderr
    assert not jobs()


# ----------------------------------------------------------------------------------------------------------- Snakemake

SNAKEMAKE = ['snakemake', '-s', EXAMPLES / 'Snakefile', '--config', 'shape=torus.ply', 'core=core.vtp', 'work=work',
             'tasks=2', f"options={' '.join(PLAN[1:])}"]


def test_snakemake_on_one_machine(whole, here):
    run([*SNAKEMAKE, '--cores', '2'], here)
    expect_core(whole, here / 'core.vtp')


def test_snakemake_by_slurm_with_a_killed_program(whole, here):
    command = [*SNAKEMAKE, '--jobs', '4', '--cluster', 'sbatch --parsable --cpus-per-task={threads} --mem={resources.mem_mb}']
    kill_programs(here, 1)
    run(command, here)
    expect_killed(here, 1)
    expect_core(whole, here / 'core.vtp')


# ---------------------------------------------------------------------------------------------------------------- Dask

def test_dask_with_a_killed_program(whole, here):
    command = ['/usr/bin/python3', str(EXAMPLES / 'dask_run.py'), 'work', 'core.vtp', '6', '--', *PLAN]
    kill_programs(here, 2)
    run(command, here)
    expect_killed(here, 2)
    expect_core(whole, here / 'core.vtp')


# ----------------------------------------------------------------------------------------------------------------- MPI

def mpi(ranks, *words):
    return ['mpirun', '--allow-run-as-root', '--oversubscribe', '-n', ranks, 'quench-mpi', *words]


@pytest.fixture(scope='session')
def planned(whole, tmp_path_factory):
    work = tmp_path_factory.mktemp('planned') / 'work'
    run(['quench', 'bricks', 'plan', *PLAN, '-o', work], whole)
    return work


@pytest.mark.parametrize('ranks', [1, 2, 3, 8])
def test_mpi(whole, planned, tmp_path, ranks):
    files = sorted(planned.rglob('*'))
    run(mpi(ranks, planned, '-o', 'core.vtp'), tmp_path)
    expect_core(whole, tmp_path / 'core.vtp')
    assert sorted(planned.rglob('*')) == files  # nothing is written there


def test_mpi_inside_a_job_of_slurm(whole, planned, tmp_path):
    line = ' '.join(map(str, mpi(2, planned, '-o', 'core.vtp')))
    run(['sbatch', '--wait', '--ntasks=2', '--output=log', '--wrap', line], tmp_path)
    expect_core(whole, tmp_path / 'core.vtp')


def test_mpi_fails_with_one_sentence_and_the_exit_code(planned, tmp_path):
    def sentences(command, code):
        lines = run(command, tmp_path, code=code).stderr.splitlines()
        return [line for line in lines if line.startswith('quench-mpi: ')]
    assert sentences(mpi(3, 'nowhere', '-o', 'core.vtp'), 3) == ["quench-mpi: 'nowhere' holds no plan of bricks"]
    assert sentences(mpi(3, planned, '-o', 'core.xyz'), 2)[0].startswith('quench-mpi: ')
    (tmp_path / 'core.vtp').write_text('')
    assert sentences(mpi(2, planned, '-o', 'core.vtp'), 2) == [
        "quench-mpi: 'core.vtp' exists; give --overwrite to replace it"]
    assert len(sentences(mpi(2, planned), 2)) == 1  # no -o
    run(['cp', '-r', planned, 'work'], tmp_path)
    (tmp_path / 'work' / 'shape' / '000001.runs').write_text('damaged')
    assert sentences(mpi(3, 'work', '-o', 'core.vtp', '--overwrite'), 3) == [
        "quench-mpi: 'work/shape/000001.runs' cannot be used: it is damaged"]
    assert (tmp_path / 'core.vtp').read_text() == ''


def test_mpi_ends_with_a_killed_process(planned, tmp_path):
    def ranks():
        return [pid for pid in subprocess.run(['pgrep', '-f', f'^quench-mpi {planned} '], capture_output=True,
                                              text=True, check=False).stdout.split()]
    with subprocess.Popen(mpi('3', str(planned), '-o', 'core.vtp'), cwd=tmp_path, env=ENVIRONMENT,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as all_of_it:
        pids = wait_for(lambda: len(ranks()) == 3 and ranks(), 'three processes')
        os.kill(int(pids[1]), signal.SIGKILL)
        assert all_of_it.wait() != 0
    assert not (tmp_path / 'core.vtp').exists()
