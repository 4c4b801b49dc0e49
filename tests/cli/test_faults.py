"""Faults from the command line: listed, and acting where they are asked for."""

from polydraulic import simulate
from polydraulic.tables import read_table


def test_faults_are_listed_by_their_owners(call):
    code, out, _ = call("faults --machine wheel_loader")
    names = [line.split()[0] for line in out.splitlines()]
    assert (code, names[:3]) == (0, ["work.pump_worn", "work.pump_relief_low", "work.torque_limit_off"])
    assert "lift.p_a.freeze" in names
    code, out, _ = call("faults lift.p_a --machine wheel_loader")
    assert [line.split()[0] for line in out.splitlines()] == ["lift.p_a.bias", "lift.p_a.drift", "lift.p_a.freeze"]
    code, _, err = call("faults boom --machine wheel_loader")
    assert (code, "no faults of 'boom'; there are some of lift" in err) == (2, True)


def test_a_run_breaks_as_it_is_told(call, tmp_path):
    run = ("simulate", "random:1:2", "--machine", "wheel_loader", "--out", tmp_path / "run.csv", "--fault")
    code, out, _ = call(*run, "work.pump_worn 20 % from 1 s")
    assert "fault: work.pump_worn from 1 s: pump of work worn: its flow is 20 % low" in out
    worn, healthy = read_table(tmp_path / "run.csv"), simulate("wheel_loader", "exact", "random:1:2")
    assert code == 0
    before = healthy["time"] <= 1.0
    assert (worn["work.q_pump"] == healthy["work.q_pump"])[before].all()
    assert worn["work.q_pump"][~before].max() < healthy["work.q_pump"][~before].max()
    code, _, err = call(*run, "work.pump_worn 95 %")
    assert (code, "size = 95 %: must be above 0 % and at most 90 %" in err) == (2, True)


def test_a_log_holds_what_sensors_read_of_it(call, tmp_path):
    (tmp_path / "s.toml").write_text('[[sensor]]\ncolumn = "lift.angle"\nunit = "deg"\nraster = "10 ms"\n')
    record = ("record", "random:1:2", "--machine", "wheel_loader", "--sensors", tmp_path / "s.toml", "--out")
    assert call(*record, tmp_path / "log.csv")[0] == 0
    code, out, _ = call(*record, tmp_path / "off.csv", "--fault", "lift.angle.freeze from 1 s")
    assert (code, "fault: lift.angle.freeze from 1 s: sensor of lift.angle stays at what it reads" in out) == (0, True)
    log, off = (read_table(tmp_path / name)["lift.angle"] for name in ("log.csv", "off.csv"))
    assert (log[:100] == off[:100]).all()
    assert len(set(off[100:])) == 1 < len(set(log[100:]))
    code, _, err = call(*record, tmp_path / "no.csv", "--fault", "lift.p_a.freeze")
    assert (code, "a fault is of 'lift.p_a', which no sensor reads" in err) == (2, True)
