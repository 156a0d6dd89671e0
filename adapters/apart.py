"""MPI jobs of several processes, apart: `mpirun` listens on all addresses, so a job has a network of its own, which nobody
else sees."""
import fcntl
import os
import socket
import struct
import sys


def alone(command):
    """The command, in a network of its own with a loopback to talk over, and ended with all that it starts."""
    return ["unshare", "--map-root-user", "--net", "--pid", "--fork", "--kill-child", sys.executable, os.path.abspath(__file__), *command]


def mpirun(processes):
    """What starts so many processes of the program whose words come after it."""
    return ["mpirun", "-np", str(processes), "--oversubscribe", "--bind-to", "none"]


def surroundings(folder):
    """What such a job finds: its files are in this folder, and its processes talk over memory that they share."""
    given = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    return dict(
        given, OMP_NUM_THREADS="1", OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_btl="self,vader", OMPI_MCA_pml="ob1",
        OMPI_MCA_orte_tmpdir_base=folder,
        OMPI_MCA_btl_vader_backing_directory=folder, HWLOC_COMPONENTS="-gl", OMPI_ALLOW_RUN_AS_ROOT="1",
        OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
    )  # fmt: skip


def with_loopback(command):
    # A session of its own: its processes wait for each other busily, and a kernel that shares processors by session gives them
    # their turns beside a busy neighbour.
    os.setsid()
    set_flags, up = 0x8914, 1
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as handle:
        fcntl.ioctl(handle, set_flags, struct.pack("16sH14x", b"lo", up))
    os.execvp(command[0], command)


if __name__ == "__main__":
    with_loopback(sys.argv[1:])
