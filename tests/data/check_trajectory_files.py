"""Reads trajectory files with NumPy, PyYAML, mcap and rosbags, and compares all of them with the table in JSON: python check_trajectory_files.py FOLDER"""
import json
import re
import sys
from pathlib import Path

import numpy as np
import yaml
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore

FOLDER = Path(sys.argv[1])
table = json.loads((FOLDER / 'json').read_text())
rows = np.array(table['rows'])
n = (rows.shape[1] - 1) // 3
time, q, qd, qdd = rows[:, 0], rows[:, 1:1 + n], rows[:, 1 + n:1 + 2 * n], rows[:, 1 + 2 * n:]
names = [f'arm_joint_{j + 1}' for j in range(n)]
compared = 1


def agree(name, found, expected, within):
    global compared
    for a, b in zip(found, expected, strict=True):
        a = np.asarray(a, float)
        assert a.shape == b.shape and np.abs(a - b).max() <= within, f'{name}: {np.abs(a - b).max()}'
    compared += 1


# Ten decimals at most.
TEXT = 0.51e-10
csv = np.genfromtxt(FOLDER / 'csv', delimiter=',', names=True)
assert csv.dtype.names[:3] == ('time', 'q1', 'q2')
agree('csv', [np.array(csv.tolist())], [rows], TEXT)
npz = np.load(FOLDER / 'npz', allow_pickle=False)
agree('npz', [npz['time'], npz['q'], npz['qd'], npz['qdd']], [time, q, qd, qdd], 0)
for name, read in [('joint_trajectory', json.loads), ('yaml', lambda text: yaml.load(text, yaml.CSafeLoader)['trajectory'])]:
    message = read((FOLDER / name).read_text())
    assert message['joint_names'] == names
    points = message['points']
    stamps = [p['time_from_start']['sec'] + 1e-9 * p['time_from_start']['nanosec'] for p in points]
    agree(name, [stamps] + [[p[k] for p in points] for k in ('positions', 'velocities', 'accelerations')], [time, q, qd, qdd], 1e-9)
program = (FOLDER / 'urscript').read_text()
moves = re.findall(r'servoj\(\[(.*?)\]', program)
agree('urscript', [[list(map(float, m.split(','))) for m in moves]], [q], TEXT)
store = get_typestore(Stores.ROS2_HUMBLE)
with open(FOLDER / 'mcap', 'rb') as stream:
    messages = [(m.log_time, store.deserialize_cdr(m.data, s.name)) for s, c, m in make_reader(stream).iter_messages()]
assert all(m.name == names for _, m in messages)
agree('mcap', [[1e-9 * t for t, _ in messages], [m.position for _, m in messages], [m.velocity for _, m in messages]], [time, q, qd], 1e-9)
print(f'{compared} files agree')
