"""Text of the march that repairs a circuit of n valves in series; what it does is said in `march`."""

from polydraulic.machine.circuits.wording import each, repeated, valves


def march_text(n: int) -> str:
    """Text of `series_n_repair` and of what it asks."""
    return f'''
@kernel
def series_{n}_asks(outlet, y, flow, base, {valves(n)}):
    """Whether the pump cannot give what is asked of it with y over `base` at an outlet, where `flow` leaves.

    Outlet {n + 1} is the tank, at the node before the last valve; the others are inlets.
    """
    x = Climb(y, flow)
    x = joined(x, k_{n}.inlet, p_{n}, base) if outlet > {n} else x
{repeated("    x = climbed(x, k_~, p_~, base) if outlet > ~ else x", range(n - 1, 0, -1))}
    return asks_too_much(x, base, pump)


@kernel
def series_{n}_repair({valves(n)}):
    """Flows by the march: from the tank to the first valve, the root at each outlet is found by halving."""
    m = unreached()
{repeated("    q_~ = 0.0", range(1, n + 2))}
    for step in range({n + 1}):
        outlet = {n + 1} - step
        k, p = k_{n}.bypass, pump.p_return
{repeated("        k, p = (k_~.inlet if outlet == ~ else k), (p_~ if outlet == ~ else p)", range(n, 0, -1))}
        if not m.reached and k > 0.0:
            beyond = series_{n}_asks(outlet, 0.0, 0.0, p, {valves(n)})
            m = m if beyond else reached_at(p, pump)
        if m.reached:
            low, high = lowest_root(m, p), highest_root(m, p)
            stays_shut = low <= 0.0 and series_{n}_asks(outlet, 0.0, m.flow_low, p, {valves(n)})
            high = 0.0 if stays_shut else high
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if k <= 0.0 or middle <= low or middle >= high:
                    break
                asks = series_{n}_asks(outlet, middle * middle, m.flow_low + k * middle, p, {valves(n)})
                low = low if asks else middle
                high = middle if asks else high
            m = before_outlet(m, p, low, high, k)
{repeated("            q_~ = k * low if outlet == ~ else q_~", range(1, n + 2))}
            if outlet > 1 and outlet <= {n}:
                bypass = k_1.bypass
{repeated("                bypass = k_~-.bypass if outlet == ~ else bypass", range(3, n + 1))}
                m = before_bypass(m, bypass)
{repeated("    w_~ = q_~+" + "", range(n, n + 1))}
{repeated("    w_~ = w_~+ + q_~+", range(n - 1, 0, -1))}
    q_pump = delivers_at(m, pump)
    status = march_status(m, q_pump, pump)
    return series_{n}_seen(q_pump, {each("q_~", 1, n)}, {each("w_~", 1, n)}, {valves(n)}, status)
'''
