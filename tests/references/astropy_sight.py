"""The direction from a satellite to a place on the ground, by astropy."""

import datetime as dt
import warnings

import numpy as np

from jaxatt.environment import epoch


def astropy_sight(days, time, position, site):
    """Unit vector in inertial axes from a satellite to a place.

    days : time zero, since J2000.  time : [s].  position : (3,) [m], of the satellite.
    site : latitude, longitude [rad], geodetic, and height [m].
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from astropy import units
        from astropy.coordinates import EarthLocation
        from astropy.time import Time
        from astropy.utils.iers import conf

        with (
            conf.set_temp("auto_download", False),
            conf.set_temp("auto_max_age", None),
            conf.set_temp("iers_degraded_accuracy", "ignore"),
        ):
            date = epoch.J2000 + dt.timedelta(days=days, seconds=time)
            when = Time(date.replace(tzinfo=None), scale="utc")
            degrees = np.rad2deg(site[:2])
            place = EarthLocation.from_geodetic(degrees[1], degrees[0], site[2])
            there = place.get_gcrs(when).cartesian.xyz.to_value(units.m)
    sight = there - np.asarray(position)
    return sight / np.linalg.norm(sight)
