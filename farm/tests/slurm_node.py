"""A Slurm cluster of one node, in a folder of its own."""

import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

CONFIG = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_interval=1
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> str:
    """Returns why no cluster can be started here; empty if one can."""
    if os.geteuid() != 0:
        return "a test cluster needs root"
    names = ["munged", "slurmctld", "slurmd", "sbatch", "srun"]
    lacking = [name for name in names if not shutil.which(name)]
    return f"{', '.join(lacking)} not there: install slurm-wlm and munge" if lacking else ""


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class SlurmNode:
    """A running cluster."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ["state", "spool"]:
            (folder / name).mkdir()
        config = folder / "slurm.conf"
        config.write_text(
            CONFIG.format(
                folder=folder,
                host=socket.gethostname().split(".")[0],
                controller_port=free_port(),
                node_port=free_port(),
                cpus=os.cpu_count(),
            )
        )
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.environment = {**os.environ, "SLURM_CONF": str(config)}
        names = ["key", "socket", "pid", "log", "seed"]
        options = [
            f"--{name}{'' if name == 'socket' else '-file'}={folder}/munge.{name}" for name in names
        ]
        self.daemons = [
            self.start("munged", "--force", "--foreground", *options),
            self.start("slurmctld", "-D"),
            self.start("slurmd", "-D"),
        ]

    def start(self, *command: str) -> subprocess.Popen[bytes]:
        log = (self.folder / f"{command[0]}.out").open("wb")
        daemon = subprocess.Popen(command, env=self.environment, stdout=log, stderr=log)
        time.sleep(0.5)
        return daemon

    def stop(self) -> None:
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            daemon.wait(timeout=20)

    def command(self, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            words,
            env={**self.environment, **variables},
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )

    def is_ready(self, seconds: float) -> bool:
        """Waits for the node to take jobs."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if "idle" in self.command("sinfo", "-h", "-o", "%T").stdout:
                return True
            time.sleep(0.5)
        return False

    def logs(self) -> str:
        return "\n".join(path.read_text() for path in self.folder.glob("slurm*.log"))

    def states(self, job: str, seconds: float) -> list[str]:
        """Waits for the end of an array job; returns the states of its tasks, in their order."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            shown = self.command("scontrol", "show", "job", job, "-o").stdout.splitlines()
            tasks = [dict(word.split("=", 1) for word in line.split() if "=" in word) for line in shown]
            if tasks and all(task["JobState"] in ["COMPLETED", "FAILED"] for task in tasks):
                tasks.sort(key=lambda task: int(task["ArrayTaskId"]))
                return [task["JobState"] for task in tasks]
            time.sleep(0.5)
        raise TimeoutError(self.logs())
