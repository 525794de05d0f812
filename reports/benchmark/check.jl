# Correct digits of a trajectory of the heavy top benchmark:  julia check.jl TOP.csv MINE.csv [AT_LEAST]
#
# TOP.csv is a file of the benchmark; MINE.csv has the columns t, p, q, r, gamma1, gamma2, gamma3 in any
# order, and q0, q1, q2, q3 where the attitude is to be judged.  Decimals are read to 300 bits.  Digits are
# -log10 of the larger of the error of omega, relative to the largest |omega| of TOP.csv, and the error of
# gamma; of the attitude -log10 of its error, of q or -q.  Errors are the largest of a component.  Exit
# code 0; 1 with fewer digits than AT_LEAST or a missing time; 2 for bad input.
using Printf
setprecision(BigFloat, 300)
const OMEGA, GAMMA, ATTITUDE = ["p", "q", "r"], ["gamma1", "gamma2", "gamma3"], ["q0", "q1", "q2", "q3"]

function number(text)
    x = parse(BigFloat, strip(text))
    isfinite(x) || error("expected a number, not $text")
    return x
end

function table(path) # rows by the names of their columns
    lines = filter(line -> !isempty(strip(line)), readlines(path))
    names = strip.(split(lines[1], ","))
    return [Dict(zip(names, number.(split(line, ",")))) for line in lines[2:end]]
end

off(mine, row, names, sign = 1) = maximum(abs(sign * mine[name] - row[name]) for name in names)
digits_of(x) = x == 0 ? 50.0 : Float64(clamp(-log10(x), 0, 50))

function judge(top, file, least = nothing)
    tops, rows = table(top), table(file)
    scale = maximum(sqrt(sum(row[name]^2 for name in OMEGA)) for row in tops)
    worst = 50.0
    println("t  state  attitude")
    for row in tops
        t = row["t"]
        n = findfirst(one -> abs(one["t"] - t) <= abs(t) / 10^9, rows)
        if n === nothing
            t == 0 && continue
            @printf("%g  missing\n", Float64(t))
            worst = 0.0
            continue
        end
        mine = rows[n]
        here = [digits_of(max(off(mine, row, OMEGA) / scale, off(mine, row, GAMMA)))]
        if all(name -> haskey(mine, name), ATTITUDE)
            push!(here, digits_of(min(off(mine, row, ATTITUDE), off(mine, row, ATTITUDE, -1))))
        end
        @printf("%g", Float64(t))
        foreach(x -> @printf("  %.2f", x), here)
        println()
        worst = min(worst, minimum(here))
    end
    @printf("worst %.2f correct digits\n", worst)
    return least !== nothing && worst < parse(Float64, least) ? 1 : 0
end

try
    global code = judge(ARGS...)
catch fault
    println(stderr, "check.jl TOP.csv MINE.csv [AT_LEAST]: ", sprint(showerror, fault))
    global code = 2
end
exit(code)
