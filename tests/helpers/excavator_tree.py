"""cat215b as a machine that is described by links."""

from polydraulic.parameters.load import load_layout


def excavator_tree():
    """cat215b_bucket without its bucket: the boom alone on its pump."""
    machine = load_layout("cat215b_bucket")
    circuits = tuple(c._replace(functions=tuple(f for f in c.functions if f != "bucket")) for c in machine.circuits)
    return machine._replace(
        links=machine.links[:3],
        functions=machine.functions[:3],
        circuits=circuits,
        tip=("stick", machine.link("bucket").at),
    )
