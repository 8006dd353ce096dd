"""start"""
    @pytest.mark.parametrize("hole", ["right half", "middle", "scattered", "corners"])
    def test_start_pixels_beyond_the_rim_stay(self, hole: str) -> None:
        """Law 7: what lies deeper than the rim keeps its source, and its look beyond rim + feather; no hole is left."""
        self.claims(Ability.START)

        def law(case: Case) -> None:
            start, feather = self._start(case, hole), 3
            out = case.grow(self.method, start=start)
            assert not out.map.holes.any()
            rim = self.rim(case.exemplars, case.size)
            kept, clear = _depth(start, case.wrap) > rim, _depth(start, case.wrap) > rim + feather
            assert same_pixels(out.map, start, kept)
            filled = case.grow(self.method).map
            before = replace(start, **_laid_over(filled, start))
            old = Synthesis(case.exemplars, before, Blend(0), self.method)
            for f in (0, feather):
                assert (out.render(feather=f).samples[clear] == old.render(feather=f).samples[clear]).all()

        self.for_all(law)

    def test_the_rim_can_be_chosen(self) -> None:
        """Law 7: with a rim of 0 every known start pixel keeps its source."""
        self.claims(Ability.START)

        def law(case: Case) -> None:
            start = self._start(case, "middle")
            canvas = Canvas(*case.size, case.wrap, start, rim=0)
            settled = self.method.settled(case.exemplars, canvas)
            out = settled.synthesize(case.exemplars, canvas, case.seed, Run(threads=1))
            assert same_pixels(out, start, ~start.holes)
            assert not out.holes.any()

        self.for_all(law, 2)

    def test_a_start_without_holes_is_the_result(self) -> None:
        """Law 7: where all is known nothing changes."""
        self.claims(Ability.START)

        def law(case: Case) -> None:
            full = case.grow(self.method).map
            assert same_map(case.grow(self.method, start=full, seed=case.seed ^ 1).map, full)

        self.for_all(law, 2)

    def test_the_picture_under_a_start_need_not_be_sampled(self) -> None:
        """Law 7: a start map may show an exemplar that is wholly unusable; only its own pixels show it."""
        self.claims(Ability.START)
        self.claims(Ability.SEVERAL)
        below = Exemplar.of(texture(26, 30, 3, 5), usable=np.zeros((26, 30), bool))
        sampled = Exemplar.of(texture(28, 24, 3, 6))
        start = identity((below.source, sampled.source), 0)
        which = np.array(start.which)
        which[:, 15:] = HOLE
        start = replace(start, which=which)
        out = synthesize([below, sampled], None, self.method, start=start, run=Run(threads=1))
        assert out.map.which is not None
        assert (out.map.which[:, 15:] == 1).all()
        deep = _depth(start, Wrap.NONE) > self.rim((below, sampled), (26, 30))
        assert (out.map.which[deep] == 0).all()
        assert (out.render(feather=0).pixels[deep] == below.base.pixels[deep]).all()

    def _start(self, case: Case, hole: str) -> SourceMap:
        """Grow a map with another seed and cut holes into it."""
        full = case.grow(self.method, seed=case.seed ^ 0xABCD).map
        height, width = case.size
        y, x = np.mgrid[:height, :width]
        holes = {
            "right half": x >= width // 2,
            "middle": (abs(2 * y - height) < height / 2) & (abs(2 * x - width) < width / 2),
            "scattered": noise(height, width, case.seed) % np.uint64(17) == 0,
            "corners": (np.minimum(y, height - 1 - y) < 6) & (np.minimum(x, width - 1 - x) < 5),
        }[hole]
        which = np.zeros(case.size, np.uint8) if full.which is None else np.array(full.which)
        which[holes] = HOLE
        return replace(full, which=which, yx=np.where(holes[:, :, None], 0, full.yx))
