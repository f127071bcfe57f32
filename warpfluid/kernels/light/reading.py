"""What a ray meets at a place, as native source: fields read linearly or cubically, and what their values do to light.

Cubic is the interpolation of Catmull and Rom ("A Class of Local Interpolating Splines", 1974), which is smooth where
linear has an edge at every voxel; what it makes of less than nothing is nothing.
"""

EXTINCTION, EMISSION, ALBEDO = range(3)
MOST_SUNS = 8

# Defines `place(q)`: taps and weights at coordinate q of the main axis, on one plane or two; 0 is read beyond the box,
# and the nearest voxel of what `around` reads.
PLACE = """
    struct Axis { size_t low, high; float share, first, second; };
    struct Place { Axis along; size_t at[4]; float weight[4], clamped[4]; };
    const auto axis_at = [](double p, int n, size_t stride) {
        const int i = (int)(p + 4.0) - 4;
        const float share = (float)(p - i);
        if (i >= 0 && i + 1 < n) return Axis{i * stride, (i + 1) * stride, share, 1.0f - share, share};
        const size_t low = wp::clamp(i, 0, n - 1) * stride, high = wp::clamp(i + 1, 0, n - 1) * stride;
        return Axis{low, high, share, i >= 0 && i < n ? 1.0f - share : 0.0f, i >= -1 && i + 1 < n ? share : 0.0f};
    };
    const auto place = [&](double q) {
        const Axis one = axis_at(base_a + q * slope_a, size_a, stride_a);
        const Axis two = axis_at(base_b + q * slope_b, size_b, stride_b);
        const float s = one.share, t = two.share;
        return Place{
            axis_at(q, size_d, stride_d),
            {one.low + two.low, one.low + two.high, one.high + two.low, one.high + two.high},
            {one.first * two.first, one.first * two.second, one.second * two.first, one.second * two.second},
            {(1.0f - s) * (1.0f - t), (1.0f - s) * t, s * (1.0f - t), s * t}};
    };
    const auto on_plane = [](const float* data, int step, size_t plane, const Place& here, const float* weight) {
        const float* from_plane = data + step * plane;
        return weight[0] * from_plane[step * here.at[0]] + weight[1] * from_plane[step * here.at[1]]
            + weight[2] * from_plane[step * here.at[2]] + weight[3] * from_plane[step * here.at[3]];
    };
    const auto read = [&](const float* data, const Place& here) {
        const float first = here.along.first * on_plane(data, 1, here.along.low, here, here.weight);
        if (here.along.share == 0.0f) return first;
        return first + here.along.second * on_plane(data, 1, here.along.high, here, here.weight);
    };
    struct Cubic { size_t at[4]; float weight[4]; int count; };
    const auto cubic_at = [](double p, int n, size_t stride) {
        const int i = (int)(p + 4.0) - 4;
        const float s = (float)(p - i), r = 1.0f - s;
        if (s == 0.0f) return Cubic{{wp::clamp(i, 0, n - 1) * stride}, {i >= 0 && i < n ? 1.0f : 0.0f}, 1};
        Cubic found = {{}, {-0.5f * s * r * r, 1.0f + s * s * (1.5f * s - 2.5f), 1.0f + r * r * (1.5f * r - 2.5f),
            -0.5f * r * s * s}, 4};
        for (int k = 0, j = i - 1; k < 4; ++k, ++j) {
            found.at[k] = wp::clamp(j, 0, n - 1) * stride;
            if (j < 0 || j >= n) found.weight[k] = 0.0f;
        }
        return found;
    };
    const auto read_cubic = [](const float* data, const Cubic* taps) {
        float total = 0.0f;
        for (int i = 0; i < taps[0].count; ++i)
            for (int j = 0; j < taps[1].count; ++j) {
                const float* from = data + taps[0].at[i] + taps[1].at[j];
                float row = 0.0f;
                for (int k = 0; k < taps[2].count; ++k) row += taps[2].weight[k] * from[taps[2].at[k]];
                total += taps[0].weight[i] * taps[1].weight[j] * row;
            }
        return wp::max(total, 0.0f);
    };
    const auto around = [&](const float* data, int step, const Place& here) {
        const float first = on_plane(data, step, here.along.low, here, here.clamped);
        if (here.along.share == 0.0f) return first;
        return first + here.along.share * (on_plane(data, step, here.along.high, here, here.clamped) - first);
    };
"""

# Defines `meet(q)`: what the medium does at a place: extinction, light given off, light given off or scattered.
MEET = f"""
    struct Sample {{ double q; float density, extinction, emission[3], light[3]; }};
    float sun[3 * {MOST_SUNS}];
    const int suns = scene.shadows.data ? scene.shadows.shape[0] : 0;
    const double g = scene.anisotropy;
    const size_t voxels = (size_t)size[0] * size[1] * size[2];
    for (int k = 0; k < suns; ++k) {{
        const float* to_sun = scene.suns.data + 6 * k;
        const double cosine = (to_sun[0] * toward[0] + to_sun[1] * toward[1] + to_sun[2] * toward[2])
            / wp::sqrt(ax * ax + az * az + ay * ay);
        const double base = 1.0 + g * g - 2.0 * g * cosine;
        const double phase = (1.0 - g * g) / (12.566370614359172 * base * wp::sqrt(base));
        for (int c = 0; c < 3; ++c) sun[3 * k + c] = (float)(to_sun[3 + c] * phase);
    }}
    struct Entry {{ int low, high; float share, factor; }};
    const auto entry = [&](int which, int count, const float* values) {{
        const float at = wp::clamp(values[scene.reads[which]] * scene.per_entry[which], 0.0f, (float)(count - 1));
        const int low = (int)at, times = scene.times[which];
        return Entry{{low, wp::min(low + 1, count - 1), at - low, times < 0 ? 1.0f : wp::max(values[times], 0.0f)}};
    }};
    const auto colour = [&](int which, const wp::array_t<float>& entries, const float* values, float* out) {{
        const Entry e = entry(which, entries.shape[0], values);
        const float *low = entries.data + 3 * e.low, *high = entries.data + 3 * e.high;
        for (int c = 0; c < 3; ++c) out[c] = e.factor * (low[c] + e.share * (high[c] - low[c]));
    }};
    const auto fade_at = [&](double q) {{
        const double at[3] = {{q, base_a + q * slope_a, base_b + q * slope_b}};
        const int sizes[3] = {{size_d, size_a, size_b}};
        float product = 1.0f;
        for (int i = 0; i < 3; ++i) {{
            const double inside = wp::min(at[i] + 0.5, sizes[i] - 0.5 - at[i]);
            const float part = (float)wp::clamp(inside / scene.edge_fade, 0.0, 1.0);
            product *= part * part * (3.0f - 2.0f * part);
        }}
        return product;
    }};
    const auto scatter = [&](const Place& here, const float* values, Sample& found) {{
        float albedo[3], arriving[3] = {{}};
        colour({ALBEDO}, scene.albedo, values, albedo);
        if (scene.ambient.data)
            for (int c = 0; c < 3; ++c) arriving[c] = around((const float*)scene.ambient.data + c, 3, here);
        for (int k = 0; k < suns; ++k) {{
            const float open = around(scene.shadows.data + k * voxels, 1, here);
            for (int c = 0; c < 3; ++c) arriving[c] += open * sun[3 * k + c];
        }}
        for (int c = 0; c < 3; ++c) found.light[c] += found.extinction * albedo[c] * arriving[c];
    }};
    const auto meet = [&](double q) {{
        Sample found = {{q}};
        const Place here = place(q);
        float values[4] = {{}};
        const float* fields[4] = {{scene.f0.data, scene.f1.data, scene.f2.data, scene.f3.data}};
        if (scene.cubic) {{
            const Cubic taps[3] = {{cubic_at(q, size_d, stride_d), cubic_at(base_a + q * slope_a, size_a, stride_a),
                cubic_at(base_b + q * slope_b, size_b, stride_b)}};
            for (int i = 0; i < scene.field_count; ++i) values[i] = read_cubic(fields[i], taps);
        }} else
            for (int i = 0; i < scene.field_count; ++i) values[i] = read(fields[i], here);
        if (scene.density_field >= 0) found.density = values[scene.density_field];
        if (scene.clear && wp::max(wp::max(values[0], values[1]), wp::max(values[2], values[3])) <= 0.0f) return found;
        const float fade = scene.edge_fade > 0.0f ? fade_at(q) : 1.0f;
        if (scene.extinction.data) {{
            const Entry e = entry({EXTINCTION}, scene.extinction.shape[0], values);
            const float low = scene.extinction.data[e.low], high = scene.extinction.data[e.high];
            found.extinction = fade * e.factor * (low + e.share * (high - low));
        }}
        if (scene.emission.data) {{
            colour({EMISSION}, scene.emission, values, found.emission);
            for (int c = 0; c < 3; ++c) found.light[c] = found.emission[c] *= fade;
        }}
        if (scene.albedo.data && found.extinction > 0.0f) scatter(here, values, found);
        return found;
    }};
"""
