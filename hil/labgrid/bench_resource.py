"""Resource of labgrid: a bench, and the door where it is."""

import attr
from labgrid.factory import target_factory
from labgrid.resource import Resource


@target_factory.reg_resource
@attr.s(eq=False)
class HilBench(Resource):  # type: ignore[misc,unused-ignore]
    """Bench of a lab. ``bench``: its name; ``connect``: its own door, or a router's; who asks there says the
    driver."""

    bench: str = attr.ib(validator=attr.validators.instance_of(str))
    connect: str = attr.ib(default="tcp/127.0.0.1:7447", validator=attr.validators.instance_of(str))
