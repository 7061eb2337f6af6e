# SPDX-License-Identifier: Apache-2.0
"""Loads the plug-in beside this file, also into a ParaView that is older than its Python: 5.11 and before want
`inspect.getargspec`, which Python 3.11 has no more, and can load no plug-in of Python without it.

In ParaView: Macros -> Import new macro, once, then its button. In pvpython and pvbatch: `import load_quench` first.
"""
import inspect
import os
import shutil

if not hasattr(inspect, 'getargspec'):
    inspect.getargspec = inspect.getfullargspec

from paraview import simple  # noqa: E402  behind what it needs


def plugin():
    """The plug-in: beside this file; macros are copies, so that QUENCH_PARAVIEW may name its folder, or it is found where the
    program in PATH (or QUENCH) is installed, or in /usr/local or /usr."""
    here = os.path.dirname(os.path.realpath(globals().get('__file__', '.')))
    folders = [os.environ.get('QUENCH_PARAVIEW', here), here]
    for program in (os.environ.get('QUENCH'), shutil.which('quench')):
        if program:
            for path in (program, os.path.realpath(program)):  # a link to it may be elsewhere
                folders.append(os.path.join(os.path.dirname(os.path.abspath(path)), '..', 'share', 'quench', 'paraview'))
    for folder in (*folders, '/usr/local/share/quench/paraview', '/usr/share/quench/paraview'):
        path = os.path.join(folder, 'quench_paraview.py')
        if os.path.exists(path):
            return os.path.abspath(path)
    raise RuntimeError('quench_paraview.py is not here; set the environment variable QUENCH_PARAVIEW to its folder')


simple.LoadPlugin(plugin(), remote=False, ns=globals())
