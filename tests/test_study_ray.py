"""Studies on a real Ray cluster of two nodes on this machine, one of which dies on the way."""

import threading
import time

import pytest
from multilift import study
from multilift.study import engine_ray, store
from multilift.study import run as runner
from study_files import SMALL, fingerprint, rows, write

ray = pytest.importorskip("ray", reason="Ray is not installed: make test-ray")
from ray.cluster_utils import Cluster  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")  # Ray's own


@pytest.fixture
def cluster():
    """A head that only collects and two nodes of one processor each."""
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    nodes = [made.add_node(num_cpus=1) for _ in range(2)]
    made.wait_for_nodes()
    ray.init(address=made.address, log_to_driver=False)
    yield made, nodes
    ray.shutdown()
    made.shutdown()


def sorted_rows(folder):
    table = rows(folder).astype({"controller": str})
    return table.sort_values(["controller", "world"], ignore_index=True)


def nodes_alive(expected):
    """How many nodes the head takes for alive; it hears of a death by a check from time to time."""
    until = time.monotonic() + 60
    while time.monotonic() < until:
        alive = sum(node["Alive"] for node in ray.nodes())
        if alive == expected:
            break
        time.sleep(0.2)
    return alive


def test_a_killed_node_loses_no_chunk_and_changes_no_bit(tmp_path, cluster, monkeypatch):
    monkeypatch.setattr(runner.page, "write", lambda *_: None)
    made, nodes = cluster
    text = SMALL.replace("count = 10", "count = 100").replace("= 0.05", "= 2.0")
    plan = study.load(write(tmp_path, text))
    begun = threading.Event()
    written = []
    real = store.Store.write

    def write_and_tell(self, chunk):
        real(self, chunk)
        written.append(chunk.start)
        if len(written) == 3:
            begun.set()

    monkeypatch.setattr(store.Store, "write", write_and_tell)

    def kill():
        begun.wait(120)
        time.sleep(0.1)
        made.remove_node(nodes[1], allow_graceful=False)

    killer = threading.Thread(target=kill)
    killer.start()
    result = runner.run(plan, tmp_path / "ray", engine="ray", chunk=10)
    killer.join()
    assert len(written) == len(set(written)) == 20
    assert nodes_alive(2) == 2  # the head and one that is left
    assert result.cost.runs == 400
    runner.run(plan, tmp_path / "local", chunk=10)
    assert fingerprint(tmp_path / "ray") == fingerprint(tmp_path / "local")
    runner.run(plan, tmp_path / "rechunked", chunk=33)
    assert sorted_rows(tmp_path / "ray").equals(sorted_rows(tmp_path / "rechunked"))


def test_errors_of_a_world_arrive_as_they_are(tmp_path, cluster):
    text = SMALL.replace("[[success]]", """
[[vary]]
key = "start.vehicle_position[1][0]"
distribution = "list"
values = [2.6, 5.9]
[[vary]]
key = "start.vehicle_position[0][0]"
distribution = "list"
values = [0.8, 0.2]
[[success]]""")  # fmt: skip
    plan = study.load(write(tmp_path, text))
    with pytest.raises(study.spec.ScenarioError, match="does not permit"):
        runner.run(plan, tmp_path / "out", engine="ray")


def test_machines_with_another_multilift_are_refused(tmp_path, cluster, monkeypatch):
    monkeypatch.setattr(engine_ray, "_version", lambda: {"multilift": "0.0.0"})
    plan = study.load(write(tmp_path))
    with pytest.raises(engine_ray.ClusterError, match="another multilift"):
        runner.run(plan, tmp_path / "out", engine="ray")
