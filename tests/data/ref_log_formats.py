"""Writes one recording in the formats that dynident reads, by the libraries that people write them with, into logs/formats/.

Two joints, 200 Hz, 200 samples; `expected.csv` has every number with all its digits. Made with NumPy 2.4.6, SciPy 1.17.1, pandas 3.1.1, pyarrow 26.0.1,
mcap 1.6.0 and rosbags 0.11.9:

    pip install numpy scipy pandas pyarrow mcap rosbags zstandard
    python tests/data/ref_log_formats.py [FOLDER]
"""
import gzip, json, shutil, sys, tempfile
from pathlib import Path
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
import zstandard
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

OUT = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / 'logs' / 'formats'
JOINTS = ['shoulder', 'elbow']
N = 200
k = np.arange(N)
NS = 1_700_000_000_123_456_789 + 5_000_000 * k          # stamps since 1970 [ns]
t = 0.005 * k
rng = np.random.default_rng(7)
q = np.column_stack([np.sin(2.3 * t), 0.7 * np.cos(1.1 * t + 0.2)]) + 1e-6 * rng.standard_normal((N, 2))
qd = np.column_stack([2.3 * np.cos(2.3 * t), -0.77 * np.sin(1.1 * t + 0.2)]) + 1e-4 * rng.standard_normal((N, 2))
tau = np.column_stack([12 * np.sin(2.3 * t + 0.4), 5 * np.cos(1.1 * t)]) + 0.05 * rng.standard_normal((N, 2))
HEAD = ['time', 'q1', 'q2', 'qd1', 'qd2', 'tau1', 'tau2']
TABLE = np.column_stack([t, q, qd, tau])


def text(names, columns, separator=',', comma=False):
    rows = [separator.join(names)] if names else []
    for row in zip(*columns):
        cells = [repr(float(v)) if isinstance(v, float) else str(v) for v in row]
        rows.append(separator.join(c.replace('.', ',') if comma else c for c in cells))
    return '\n'.join(rows) + '\n'


def numpy_files():
    np.savez(OUT / 'savez.npz', time=t, q=q, qd=qd, tau=tau, gains=np.eye(3))
    np.savez_compressed(OUT / 'transposed.npz', t=t.astype('>f8'), q=np.asfortranarray(q.T), qd=qd.T, tau=tau, note=np.array('a text'))
    np.savez_compressed(OUT / 'stamps.npz', stamp=NS.astype('datetime64[ns]'), q=q, tau=tau)
    np.savetxt(OUT / 'savetxt.txt', TABLE, header=' '.join(HEAD), fmt='%.17g')
    np.save(OUT / 'single.npy', q)


def tables():
    frame = pd.DataFrame(TABLE, columns=HEAD)
    frame.to_parquet(OUT / 'pandas.parquet')
    frame.to_csv(OUT / 'pandas.csv', float_format='%.17g')
    lists = pa.table({'stamp': pa.array(NS, pa.timestamp('ns')), 'q': pa.array(q.tolist()), 'tau': pa.array(tau.tolist(), pa.list_(pa.float64(), 2)), 'state': ['run'] * N})
    pq.write_table(lists, OUT / 'lists.parquet', compression='zstd')


def matlab():
    arrays = dict(t=t[:, None], q=q, qd=qd, tau=tau)
    scipy.io.savemat(OUT / 'version5.mat', arrays | {'label': 'a text', 'empty': np.zeros((0, 0))})
    scipy.io.savemat(OUT / 'version7.mat', {'log': {'time': t, 'q': q.T, 'tau': tau.T, 'robot': {'name': 'two links'}}}, do_compression=True)
    whole = dict(t=k[None, :] * 5, q=q, tau=tau)
    scipy.io.savemat(OUT / 'milliseconds.mat', whole, do_compression=True)


def bags():
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    JointState, Header, Time = types['sensor_msgs/msg/JointState'], types['std_msgs/msg/Header'], types['builtin_interfaces/msg/Time']
    Array, Layout = types['std_msgs/msg/Float64MultiArray'], types['std_msgs/msg/MultiArrayLayout']
    String = types['std_msgs/msg/String']

    def state(i, names, position, velocity, effort):
        stamp = Time(sec=int(NS[i] // 10**9), nanosec=int(NS[i] % 10**9))
        return JointState(header=Header(stamp=stamp, frame_id='base'), name=list(names), position=np.array(position, float), velocity=np.array(velocity, float), effort=np.array(effort, float))

    def write(name, plugin, messages, compression=None):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / 'bag'
            writer = Writer(path, version=9, storage_plugin=plugin)
            if compression:
                writer.set_compression(compression, CompressionFormat.ZSTD)
            with writer:
                connections = {}
                for topic, ns, message in messages:
                    if topic not in connections:
                        connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
                    writer.write(connections[topic], int(ns), store.serialize_cdr(message, message.__msgtype__))
            stored = next(p for p in path.iterdir() if p.suffix != '.yaml')
            shutil.copy(stored, OUT / name)

    def joints():
        for i in range(N):
            # Received 0.4 ms after it was stamped, more or less; joints in another order than the robot's.
            yield '/joint_states', NS[i] + 400_000 + 3_000 * (i % 7), state(i, JOINTS[::-1], q[i, ::-1], qd[i, ::-1], tau[i, ::-1])

    def with_others():
        for i, message in enumerate(joints()):
            if i % 50 == 0:
                yield '/rosout', message[1] - 1, String(data='hello')
                yield '/joint_states', message[1] - 1, state(i, ['finger'], [0.01], [0.0], [0.0])
            yield message

    def apart():
        """Positions every 5 ms, torques every 4 ms on a topic of their own, which begins later."""
        both = [('/states', NS[i], state(i, JOINTS, q[i], [], [])) for i in range(N)]
        for j in range(10, 245):
            ns = NS[0] + 4_000_000 * j
            at = 0.004 * j
            stamp = Time(sec=int(ns // 10**9), nanosec=int(ns % 10**9))
            effort = [3 * at, 1 - at]
            both.append(('/torques', ns, JointState(header=Header(stamp=stamp, frame_id=''), name=JOINTS, position=np.array([]), velocity=np.array([]), effort=np.array(effort))))
        yield from sorted(both, key=lambda m: m[1])

    def arrays():
        layout = Layout(dim=[], data_offset=0)
        for i in range(N):
            yield '/arm', NS[i], Array(layout=layout, data=np.concatenate([q[i], tau[i]]))

    def only_text():
        yield '/rosout', NS[0], String(data='hello')

    write('joint_states.db3', StoragePlugin.SQLITE3, joints())
    write('joint_states.mcap', StoragePlugin.MCAP, with_others())
    write('packed_messages.db3', StoragePlugin.SQLITE3, joints(), CompressionMode.MESSAGE)
    write('packed.db3.zstd', StoragePlugin.SQLITE3, joints(), CompressionMode.FILE)
    write('apart.mcap', StoragePlugin.MCAP, apart())
    write('arrays.mcap', StoragePlugin.MCAP, arrays())
    write('no_joints.mcap', StoragePlugin.MCAP, only_text())


def json_messages():
    with open(OUT / 'json.mcap', 'wb') as stream:
        writer = McapWriter(stream)
        writer.start()
        schema = writer.register_schema('arm', 'jsonschema', json.dumps({'type': 'object'}).encode())
        channel = writer.register_channel('/arm', 'json', schema)
        for i in range(N):
            message = {'q1': q[i, 0], 'q2': q[i, 1], 'tau1': tau[i, 0], 'tau2': tau[i, 1], 'mode': 'run'}
            writer.add_message(channel, int(NS[i]), json.dumps(message).encode(), int(NS[i]))
        writer.finish()


def programs():
    """Recordings with the columns of well-known programs."""
    zeros = [0.0] * N
    of = lambda pattern, a, first: [(pattern.format(n=first + j, joint=JOINTS[j]), [float(v) for v in a[:, j]]) for j in range(2)]

    def write(name, columns, separator=' ', **style):
        (OUT / name).write_text(text([n for n, _ in columns], [c for _, c in columns], separator, **style))

    stamps = [float(v) for v in t]
    rtde = [('timestamp', stamps)] + of('target_q_{n}', 0 * q, 0) + of('target_moment_{n}', 0 * q, 0) + of('actual_q_{n}', q, 0) + of('actual_qd_{n}', qd, 0)
    write('ur_rtde.csv', rtde + of('actual_current_{n}', tau / 10, 0) + of('actual_current_as_torque_{n}', tau, 0), ',')
    write('ur_rtde_currents.csv', rtde + of('actual_current_{n}', tau / 10, 0))
    sunrise = [('ZeitInSec', [int(ns // 10**9) for ns in NS]), ('ZeitInNanoSec', [int(ns % 10**9) for ns in NS])]
    write('kuka_sunrise.log', sunrise + of('axisQMsr_LBR_iiwa_14_R820_{n}', q, 1) + of('axisTauMsr_LBR_iiwa_14_R820_{n}', tau, 1) + of('axisTauExtMsr_LBR_iiwa_14_R820_{n}', 0 * tau, 1))
    write('kuka_fri.csv', [('time', stamps)] + of('MeasuredJointPosition_{n}', q, 0) + of('MeasuredTorque_{n}', tau, 0) + of('ExternalTorque_{n}', 0 * tau, 0) + of('CommandedTorque_{n}', 0 * tau, 0), ';', comma=True)
    juggler = of('/joint_states/{joint}/position', q, 0) + of('/joint_states/{joint}/velocity', qd, 0) + of('/joint_states/{joint}/effort', tau, 0)
    write('plotjuggler.csv', [('__time', stamps), ('/joint_states/header/stamp', zeros)] + juggler, ',')
    write('libfranka.csv', [('time', stamps)] + of('q[{n}]', q, 0) + of('q_d[{n}]', 0 * q, 0) + of('dq[{n}]', qd, 0) + of('tau_J[{n}]', tau, 0) + of('tau_J_d[{n}]', 0 * tau, 0), ',')
    echo = [('%time', [int(ns) for ns in NS]), ('field.header.seq', list(range(N)))] + of('field.position{n}', q, 0) + of('field.velocity{n}', qd, 0) + of('field.effort{n}', tau, 0)
    write('rostopic_echo.csv', echo, ',')


def packed():
    plain = text(HEAD, TABLE.T.tolist()).encode()
    (OUT / 'packed.csv.zst').write_bytes(zstandard.ZstdCompressor(level=19).compress(plain))
    (OUT / 'utf16.csv').write_bytes(text(HEAD, TABLE[:60].T.tolist(), ';', comma=True).replace('\n', '\r\n').encode('utf-16'))
    with gzip.GzipFile(OUT / 'packed.parquet.gz', 'wb', mtime=0) as out:
        out.write((OUT / 'pandas.parquet').read_bytes())


def generic():
    """Messages of other kinds: one of one's own with messages within it, a force sensor at another rate, a scanner whose arrays change their length."""
    from rosbags.typesys import get_types_from_msg
    import zipfile
    store = get_typestore(Stores.ROS2_HUMBLE)
    own = 'std_msgs/Header header\nuint8 mode\nfloat64[2] positions\nmy_msgs/Motor[] motors\nint32 MODE_RUN=1\n'
    store.register(get_types_from_msg(own, 'my_msgs/msg/ArmState') | get_types_from_msg('string name\nbool on\nfloat32 temperature\nfloat64 torque\n', 'my_msgs/msg/Motor'))
    types = store.types
    Header, Time = types['std_msgs/msg/Header'], types['builtin_interfaces/msg/Time']
    Vector, Wrench, Stamped = (types[f'geometry_msgs/msg/{n}'] for n in ('Vector3', 'Wrench', 'WrenchStamped'))
    Scan = types['sensor_msgs/msg/LaserScan']
    header = lambda ns: Header(stamp=Time(sec=int(ns // 10**9), nanosec=int(ns % 10**9)), frame_id='b')

    def messages():
        for i in range(N):
            motors = [types['my_msgs/msg/Motor'](name='m' * (j + i % 3), on=True, temperature=20.5 + j, torque=float(tau[i, j])) for j in range(2)]
            yield '/arm/state', NS[i] + 300_000, types['my_msgs/msg/ArmState'](header=header(NS[i]), mode=1, positions=q[i], motors=motors)
            if i % 2 == 0:
                ns = NS[i] + 1_000_000
                yield '/wrench', ns, Stamped(header=header(ns), wrench=Wrench(force=Vector(x=0.5 * i, y=-1.0, z=2.0), torque=Vector(x=0.0, y=0.25, z=float(i))))
            if i % 20 == 0:
                angles = dict(angle_min=0.0, angle_max=1.0, angle_increment=0.1, time_increment=0.0, scan_time=0.1, range_min=0.0, range_max=9.0)
                yield '/scan', NS[i], Scan(header=header(NS[i]), ranges=np.ones(3 + i // 20, np.float32), intensities=np.ones(0, np.float32), **angles)

    for name, plugin in [('generic.mcap', StoragePlugin.MCAP), ('generic.db3', StoragePlugin.SQLITE3)]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / 'bag'
            with Writer(path, version=9, storage_plugin=plugin) as writer:
                connections = {}
                for topic, ns, message in messages():
                    if topic not in connections:
                        connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
                    writer.write(connections[topic], int(ns), store.serialize_cdr(message, message.__msgtype__))
            stored = next(p for p in path.iterdir() if p.suffix != '.yaml')
            shutil.copy(stored, OUT / name)
            with zipfile.ZipFile(OUT / f'{stored.suffix[1:]}_folder.zip', 'w', zipfile.ZIP_DEFLATED) as archive:
                for part in sorted(path.iterdir()):
                    archive.write(part, f'bag/{part.name}')
    # Two files of one recording, as rosbag2 splits them.
    with zipfile.ZipFile(OUT / 'split.zip', 'w', zipfile.ZIP_DEFLATED) as archive:
        for part in range(2):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / 'bag'
                with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
                    connection = writer.add_connection('/joint_states', 'sensor_msgs/msg/JointState', typestore=store)
                    for i in range(100 * part, 100 * part + 100):
                        message = types['sensor_msgs/msg/JointState'](header=header(NS[i]), name=JOINTS, position=q[i], velocity=qd[i], effort=tau[i])
                        writer.write(connection, int(NS[i]), store.serialize_cdr(message, message.__msgtype__))
                archive.write(next(path.glob('*.mcap')), f'bag/bag_{part}.mcap')


def lists():
    """Arrays in one field, as pandas writes lists and NumPy prints arrays."""
    as_list = lambda row: '"[' + ', '.join(repr(float(v)) for v in row) + ']"'
    as_array = lambda row: '[' + ' '.join(repr(float(v)) for v in row) + ']'
    for name, of in [('ur_rtde_lists.csv', as_list), ('ur_rtde_arrays.csv', as_array)]:
        rows = [f'{float(t[i])!r},{of(0 * q[i])},{of(q[i])},{of(qd[i])},{of(tau[i])}' for i in range(N)]
        (OUT / name).write_text('timestamp,target_q,actual_q,actual_qd,actual_current_as_torque\n' + '\n'.join(rows) + '\n')
    columns = [('timestamp', t)] + [(f'{name}[{j}]', a[:, j]) for name, a in [('target_q', 0 * q), ('actual_q', q), ('actual_qd', qd), ('actual_current_as_torque', tau)] for j in range(2)]
    (OUT / 'ur_rtde_brackets.csv').write_text(text([n for n, _ in columns], [[float(v) for v in c] for _, c in columns]))


OUT.mkdir(parents=True, exist_ok=True)
(OUT / 'expected.csv').write_text(text(HEAD, TABLE.T.tolist()))
for part in [numpy_files, tables, matlab, bags, json_messages, programs, packed, generic, lists]:
    part()
