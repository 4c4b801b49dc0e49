"""cat215b as a machine that is described by links."""

from polydraulic.parameters.load import load_machine


def excavator_tree():
    """cat215b_bucket without its bucket: the boom alone on its pump, and lines that hold at the start what is left."""
    machine, older = load_machine("cat215b_bucket"), load_machine("cat215b")
    circuits = tuple(c._replace(functions=tuple(f for f in c.functions if f != "bucket")) for c in machine.circuits)
    return machine._replace(
        links=machine.links[:3],
        functions=tuple(f._replace(initial=older.function(f.name).initial) for f in machine.functions[:3]),
        circuits=circuits,
        tip=("stick", machine.link("bucket").at),
    )
