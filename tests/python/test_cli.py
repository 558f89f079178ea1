"""The command line's own part: arguments, exit codes, one sentence for every refusal."""

import pytest
from click.testing import CliRunner

import srmp
from srmp.cli import main


def invoke(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_version_and_help():
    assert srmp.__version__ in invoke("--version").output
    single = ("demo", "plan", "replay", "verify", "check", "cover", "robots", "srdf", "cmake-dir")
    for command in [*([name] for name in single), ["bench", "mbm"]]:
        assert invoke(*command, "--help").exit_code == 0


def test_cmake_dir():
    assert invoke("cmake-dir").output.strip() == srmp.get_cmake_dir()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["bench", "mbm", "--data", ".", "--robot", "nobody"], "nobody is not a directory"),
        (["bench", "mbm", "--data", ".", "--robot", "x", "--option", "weight"], "'weight' is not KEY=VALUE"),
        (["bench", "mbm", "--data", ".", "--robot", "x", "--option", "w=1", "--option", "w=2"], "'w' is given twice"),
        (["bench", "mbm", "--data", "/nowhere", "--robot", "x"], "does not exist"),
        (["bench", "mbm", "--data", ".", "--robot", "x", "--out", "/nowhere/r.json"], "/nowhere does not exist"),
        (["plan", "--urdf", "nowhere.urdf"], "nowhere.urdf"),
        (["cover", "nowhere.urdf"], "nowhere.urdf"),
        (["robots", "arm8"], "did you mean 'arm7'"),
        (["srdf", "nowhere.urdf", "-o", "x.srdf"], "nowhere.urdf"),
        (["srdf", srmp.data_path("arm7.urdf"), "-o", "x.srdf", "--samples", "0"], "samples must be a whole number"),
        (["srdf", srmp.data_path("arm7.urdf"), "-o", "x.srdf", "--group", ""], "group is empty"),
        (["robots", "arm8"], "no robot 'arm8' is known, did you mean 'arm7'? `srmp robots` lists all"),
        (["robots", "nothing-like-it"], "no robot 'nothing-like-it' is known; `srmp robots` lists all"),
        (["cover", srmp.data_path("arm7.srdf")], "arm7.srdf"),
        (["cover", srmp.data_path("arm7.urdf"), "--accuracy", "-1"], "fine inflation"),
        (["cover", srmp.data_path("arm7.urdf"), "--accuracy", "20"], "must not exceed"),
        (["cover", srmp.data_path("arm7.urdf"), "--max-spheres", "-1"], "max-spheres"),
        (["cover", srmp.data_path("arm7.urdf"), "-o", "/nowhere/cover.json"], "/nowhere does not exist"),
    ],
)
def test_wrong_calls_end_in_one_sentence(arguments, text):
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert text in result.output
    assert "Traceback" not in result.output


def test_check_says_why():
    arm7_urdf = srmp.data_path("arm7.urdf")
    zeros = ",".join(["0"] * 7)
    result = invoke("check", "--urdf", arm7_urdf, "--state", zeros)
    assert result.exit_code in (0, 1)
    assert result.output.strip()
    beyond = invoke("check", "--urdf", arm7_urdf, "--state", ",".join(["9"] * 7))
    assert beyond.exit_code == 1
    assert "outside its limits" in beyond.output
    assert "planned joints are" in invoke("check", "--urdf", arm7_urdf, "--state", "1,2").output
    assert "did you mean 'arm7_joint1'" in invoke("check", "--urdf", arm7_urdf, "--state", "arm7_jont1=1").output
    assert "has 0 values" in invoke("check", "--urdf", arm7_urdf, "--state", "").output
    for state, where in (("0,0,0,0,0,0,x", "'x', of joint 'arm7_joint7',"), ("a=b", "'b', of joint 'a',")):
        wrong = invoke("check", "--urdf", arm7_urdf, "--state", state)
        assert wrong.exit_code == 2
        assert f"{where} is not a number" in wrong.output
    assert "give either" in invoke("check", "--urdf", arm7_urdf).output
