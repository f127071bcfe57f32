"""How a ray goes through a medium, as native source: where it reads, how its light adds up, what its steps may miss.

Rays are cut at the planes of voxels that they cross most squarely. On those a field is read with four taps, and
between two of them light is integrated by the trapezoid rule: without extinction that is Joseph's projector (1982).
Where more than the tolerance changes from one plane to the next, the interval is cut at the sides of voxels, so that
nothing is passed over, and halved, up to 16 times finer; the field is read there as well. Extinction is linear and
light is given off evenly within an interval, so that a ray's transmittance and the light that is scattered in uniform
surroundings stay exact.
"""

from warpfluid.kernels.light.bricks import BRICK

CAMERA = 16  # numbers: eye, right, up, forward (x, z, y each), pixel, shift right, shift up, perspective
UNSEEN = 1 / 64  # of what there may be between two planes at the most
SHARE = 1 / 9  # of the tolerance that one interval may use up
FINEST = 1 / 16  # of the distance between two planes
CLOSE = 1e-3  # of it; a side of a voxel so near to another is none

# The ray: `origin`, `toward` (depth 1 along forward), `main` axis and how the others run with it, `from` and `to`.
GEOMETRY = """
    const double* cam = scene.camera.data;
    const int height = color.shape[0], width = color.shape[1];
    const int size[3] = {scene.f0.shape[0], scene.f0.shape[1], scene.f0.shape[2]};
    const double u = (column - 0.5 * (width - 1) + cam[13]) * cam[12];
    const double v = (0.5 * (height - 1) - row + cam[14]) * cam[12];
    double origin[3], toward[3], near = 0.0, far = scene.limits.data ? scene.limits.data[row * width + column] : 1e30;
    const double nearest = near, farthest = far;
    for (int i = 0; i < 3; ++i) {
        const double across = u * cam[3 + i] + v * cam[6 + i];
        origin[i] = cam[i] + (cam[15] ? 0.0 : across);
        toward[i] = cam[9 + i] + (cam[15] ? across : 0.0);
        if (toward[i]) {
            const double one = (-1 - origin[i]) / toward[i], other = (size[i] - origin[i]) / toward[i];
            near = wp::max(near, wp::min(one, other));
            far = wp::min(far, wp::max(one, other));
        } else if (origin[i] <= -1 || origin[i] >= size[i])
            far = -1;
    }
    const double ax = wp::abs(toward[0]), az = wp::abs(toward[1]), ay = wp::abs(toward[2]);
    const int d = ay > wp::max(ax, az) ? 2 : az >= ax ? 1 : 0, a = d ? 0 : 1, b = d == 2 ? 1 : 2;
    const double slope_a = toward[a] / toward[d], slope_b = toward[b] / toward[d];
    const double base_a = origin[a] - origin[d] * slope_a, base_b = origin[b] - origin[d] * slope_b;
    const float length = (float)(wp::sqrt(ax * ax + az * az + ay * ay) / wp::abs(toward[d]));
    const int way = toward[d] > 0 ? 1 : -1;
    double from = origin[d] + near * toward[d], to = origin[d] + far * toward[d];
    if (near > nearest) from = way > 0 ? wp::floor(from) : wp::ceil(from);
    if (far < farthest) to = way > 0 ? wp::ceil(to) : wp::floor(to);
    const size_t strides[3] = {(size_t)size[1] * size[2], (size_t)size[2], 1};
    const size_t stride_d = strides[d], stride_a = strides[a], stride_b = strides[b];
    const int size_d = size[d], size_a = size[a], size_b = size[b];
"""

# Defines `pass(start, end)`: adds an interval's light to `seen` and `glow`, and its opacity to `hidden`.
PASS = """
    float open = 1.0f, hidden = 0.0f, seen[3] = {}, glow[3] = {}, density_sum = 0.0f;
    const auto pass = [&](const Sample& start, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        const float depth = 0.5f * h * (start.extinction + end.extinction);
        const float kept = depth < 0.1f ? 0.0f : wp::exp(-depth);
        const float mean = depth < 0.1f
            ? 1.0f - depth * (0.5f - depth * (1.0f / 6.0f - depth * (1.0f / 24.0f - depth * (1.0f / 120.0f))))
            : (1.0f - kept) / depth;  // of the transmittance within the interval
        const float factor = 0.5f * h * open * mean;
        for (int c = 0; c < 3; ++c) {
            seen[c] += factor * (start.light[c] + end.light[c]);
            glow[c] += factor * (start.emission[c] + end.emission[c]);
        }
        hidden += open * (depth < 0.1f ? depth * mean : 1.0f - kept);
        open *= depth < 0.1f ? 1.0f - depth * mean : kept;
    };
"""

# Defines `may_err` and `does_err`: what an interval may be wrong by, guessed from its ends, and known with its middle.
ERRORS = """
    const auto unequal = [&](const Sample& start, const Sample& end, float h) {  // light and extinction rise apart
        float most = 0.0f;
        for (int c = 0; c < 3; ++c)
            most = wp::max(most, wp::abs(start.light[c] * end.extinction - end.light[c] * start.extinction));
        return open * h * h * most / 12.0f;
    };
    const float slant = (float)wp::max(wp::abs(slope_a), wp::abs(slope_b));
    float unknown = 0.0f;  // how much more than seen on the planes may be met between them
    const auto may_err = [&](const Sample& start, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        float most = wp::abs(end.extinction - start.extinction);
        for (int c = 0; c < 3; ++c) most = wp::max(most, wp::abs(end.light[c] - start.light[c]));
        const float unseen = unknown * h * (float)wp::abs(end.q - start.q) * wp::abs(end.q - start.q);
        return wp::max(open * wp::max(h * most * 0.125f, unseen), unequal(start, end, h));
    };
    const auto does_err = [&](const Sample& start, const Sample& middle, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        float most = wp::abs(start.extinction + end.extinction - 2.0f * middle.extinction);
        for (int c = 0; c < 3; ++c)
            most = wp::max(most, wp::abs(start.light[c] + end.light[c] - 2.0f * middle.light[c]));
        return wp::max(open * h * most * 0.25f, 0.25f * unequal(start, end, h));
    };
"""

# Defines `bound()` and `halve(start, end)`: passes an interval in as many parts as keep the error within the bound.
# Along a ray through one voxel linear interpolation is a cubic polynomial, which ends and middle tell apart from 0.
HALVE = f"""
    const auto bound = [&]() {{
        return {SHARE} * scene.error * wp::max(1.0f, wp::max(seen[0], wp::max(seen[1], seen[2])));
    }};
    const auto crossing = [](double from, double to, double base, double slope) {{
        const double p = base + from * slope, n = (to - from) * slope > 0 ? wp::floor(p) + 1 : wp::ceil(p) - 1;
        const double share = slope ? (n - p) / ((to - from) * slope) : 1.0;
        return share < 1.0 ? from + share * (to - from) : to;
    }};
    const auto halve = [&](Sample start, const Sample& end) {{
        const double one = crossing(start.q, end.q, base_a, slope_a), two = crossing(start.q, end.q, base_b, slope_b);
        const bool ahead = way * (two - one) > 0.0;
        const double cuts[3] = {{ahead ? one : two, ahead ? two : one, end.q}};
        for (int cell = 0; cell < 3; ++cell) {{
            if (way * (cuts[cell] - start.q) < {CLOSE} && cell < 2) continue;
            Sample ends[6] = {{cuts[cell] == end.q ? end : meet(cuts[cell])}};
            for (int top = 0; top >= 0; --top) {{
                while (wp::abs(ends[top].q - start.q) > {FINEST} && may_err(start, ends[top]) > bound()) {{
                    const Sample middle = meet(0.5 * (start.q + ends[top].q));
                    const float error = does_err(start, middle, ends[top]);
                    ends[++top] = middle;
                    if (error <= bound()) break;
                }}
                pass(start, ends[top]);
                start = ends[top];
            }}
            if (start.q == end.q) break;
        }}
    }};
"""

# Defines `mark(q)` and `half_way()`: where the ray's opacity and light are half of what they come to.
HALF_WAY = """
    enum { BINS = 64 };
    float reached[BINS], per_bin = 1.0f, total = 0.0f;
    int filled = 0;
    double begun = from;
    const auto mark = [&](double q) {
        const float now = hidden + (seen[0] + seen[1] + seen[2]) * (1.0f / 3.0f);
        if (now <= total) {
            if (now == 0.0f) begun = q;
            return;
        }
        int bin = (int)wp::ceil((float)wp::abs(q - begun) * per_bin) - 1;
        for (; bin >= BINS; bin >>= 1, filled = (filled + 1) >> 1, per_bin *= 0.5f) {
            for (int i = filled; i < BINS; ++i) reached[i] = total;
            for (int i = 0; i < BINS / 2; ++i) reached[i] = reached[2 * i + 1];
        }
        for (; filled < bin; ++filled) reached[filled] = total;
        total = now;
        reached[wp::max(bin, 0)] = now;
        filled = wp::max(filled, bin + 1);
    };
    const auto half_way = [&]() {
        int bin = 0;
        while (bin + 1 < filled && reached[bin] < 0.5f * total) ++bin;
        const float low = bin ? reached[bin - 1] : 0.0f;
        const float share = (0.5f * total - low) / wp::max(reached[bin] - low, 1e-30f);
        return (begun + way * (bin + share) / per_bin - origin[d]) / toward[d];
    };
"""

# Defines `dark(q, planes)`: whether there is nothing to meet, and for how many planes on that is known.
DARK = f"""
    const double pace[3] = {{1.0 * way, way * slope_a, way * slope_b}};
    const double wait[3] = {{1.0, 1.0 / pace[1], 1.0 / pace[2]}};
    const int last[3] = {{scene.bricks.shape[d] - 1, scene.bricks.shape[a] - 1, scene.bricks.shape[b] - 1}};
    const int stride[3] = {{scene.bricks.shape[1] * scene.bricks.shape[2], scene.bricks.shape[2], 1}};
    const int hop[3] = {{stride[d], stride[a], stride[b]}};
    const auto dark = [&](double q, int& planes) {{
        const double p[3] = {{q, base_a + q * slope_a, base_b + q * slope_b}};
        const int cell = (int)(way > 0 ? wp::floor(q) : wp::ceil(q) - 1);
        int at = 0;
        float ahead = 1e6f;
        for (int i = 0; i < 3; ++i) {{
            const int brick = wp::clamp((i ? (int)(p[i] + 8.0) - 8 : cell) >> {BRICK.bit_length() - 1}, 0, last[i]);
            at += brick * hop[i];
            if (pace[i] > 0.0 ? brick == last[i] : pace[i] < 0.0 ? brick == 0 : true) continue;
            const double end = {BRICK} * (brick + (pace[i] > 0.0 ? 1 : 0));
            ahead = wp::min(ahead, (float)(i ? (end - p[i]) * wait[i] : wp::abs(end - cell - (way < 0))));
        }}
        planes = wp::max((int)ahead, 1);
        const float most = scene.bricks.data[at];
        unknown = {UNSEEN} * slant * most;
        return most == 0.0f;
    }};
"""
