# SPDX-License-Identifier: Apache-2.0
"""Runs the program from Python as program_starter.h does from C++: a process that has loaded its libraries forks one child
per run. QUENCH_START_LIBRARY names cli/faults/start_once.c as built; without it, and in a full run (QUENCH_TEST_FULL),
every run is a new process."""
import array
import atexit
import os
import socket
import struct
import subprocess
import threading

REQUEST = struct.Struct('=iIII')  # the child whose end is waited for (0: starts one), bytes, arguments, variables
of_thread = threading.local()  # a starter waits for one child at a time


class Starter:
    def __init__(self, program, library):
        self.socket, other = socket.socketpair()
        variables = {**os.environ, 'LD_PRELOAD': library, 'QUENCH_START_SOCKET': str(other.fileno())}
        self.process = subprocess.Popen([program], env=variables, pass_fds=[other.fileno()])
        other.close()
        atexit.register(self.end)

    def end(self):
        self.socket.close()
        self.process.wait()

    def reply(self):
        data = self.socket.recv(4, socket.MSG_WAITALL)
        if len(data) != 4:
            raise RuntimeError('the process that starts the program has ended')
        return struct.unpack('=i', data)[0]

    def run(self, command, folder):
        variables = [f'{name}={value}' for name, value in os.environ.items()]
        text = b''.join(os.fsencode(word) + b'\0' for word in [folder, *command, *variables])
        with open(os.devnull, 'rb') as nothing, memory_file() as out, memory_file() as error:
            streams = array.array('i', [file.fileno() for file in (nothing, out, error)])
            self.socket.sendmsg([REQUEST.pack(0, len(text), len(command), len(variables))],
                                [(socket.SOL_SOCKET, socket.SCM_RIGHTS, streams)])
            self.socket.sendall(text)
            child = self.reply()
            if child <= 0:
                raise RuntimeError('no process can be started')
            self.socket.sendall(REQUEST.pack(child, 0, 0, 0))
            code = os.waitstatus_to_exitcode(self.reply())
            return subprocess.CompletedProcess(command, code, content(out), content(error))


def memory_file():
    return os.fdopen(os.memfd_create('stream'), 'w+b', buffering=0)


def content(file):
    return os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0)


def run_program(command, cwd=None):
    """What subprocess.run() returns: exit code (-signal), stdout and stderr as bytes. stdin is empty."""
    command = [os.fspath(word) for word in command]
    library = os.environ.get('QUENCH_START_LIBRARY')
    if not library or 'QUENCH_TEST_FULL' in os.environ or 'LD_PRELOAD' in os.environ:
        return subprocess.run(command, cwd=cwd, stdin=subprocess.DEVNULL, capture_output=True)
    starters = of_thread.__dict__
    if command[0] not in starters:
        starters[command[0]] = Starter(command[0], library)
    return starters[command[0]].run(command, os.path.abspath(cwd or '.'))
