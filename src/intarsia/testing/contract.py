"""contract"""
    # ---- the laws, by their numbers in DESIGN 4 ---------------------------------------------------------------

    def test_every_pixel_is_a_usable_exemplar_pixel(self) -> None:
        """Law 1: without feather every output pixel is, bit for bit, the usable exemplar pixel that the map names."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            assert not out.map.holes.any()
            pixels = out.render(feather=0).pixels
            assert pixels.tobytes() == looked_up(case.exemplars, out.map).tobytes()
            which = np.zeros(case.size, np.uint8) if out.map.which is None else out.map.which
            for number, e in enumerate(case.exemplars):
                shown = out.map.yx[which == number]
                assert e.usable is None or e.usable[shown[:, 0], shown[:, 1]].all()

        self.for_all(law, 2 * self.examples)

    def test_size_type_and_channels_are_kept(self) -> None:
        """Law 2: the output has the size asked for, and depth, channels, kind and transfer of the exemplar."""

        def law(case: Case) -> None:
            out, base = case.grow(self.method).render(), case.exemplars[0].base
            assert (out.height, out.width) == case.size
            assert (out.pixels.dtype, out.pixels.ndim, out.channels) == (base.pixels.dtype, base.pixels.ndim, base.channels)
            assert (out.kind, out.transfer) == (base.kind, base.transfer)

        self.for_all(law)

    @pytest.mark.parametrize("feather", [0, 3])
    def test_uniform_in_uniform_out(self, feather: int) -> None:
        """Law 3: an exemplar of one colour gives that colour, with a feather, too."""

        def law(case: Case) -> None:
            first = case.exemplars[0].base.samples[0, 0]
            flat = tuple(replace(e, planes={"albedo": _filled(e.base, first)}, _memo={}) for e in case.exemplars)
            pixels = replace(case, exemplars=flat).grow(self.method).render(feather=feather).samples
            assert (pixels == first).all()

        self.for_all(law, 2)

    def test_threads_and_repetition_change_no_byte(self) -> None:
        """Law 4: one, two or four threads, called again, give the same map and the same pixels."""

        def law(case: Case) -> None:
            outs = [case.grow(self.method, run=Run(threads=n)) for n in (1, 2, 4, 1)]
            assert len({out.map.digest for out in outs}) == 1
            assert len({out.render(feather=3, run=Run(threads=n)).pixels.tobytes() for n, out in enumerate(outs, 1)}) == 1
            assert len({out.recipe_text for out in outs}) == 1

        self.for_all(law)

    @pytest.mark.parametrize("feather", [0, 4])
    def test_a_rendered_window_is_a_crop(self, feather: int) -> None:
        """Law 5: rendering a window equals that window of the whole, across wrapped borders, too."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            (height, width), wrap = case.size, case.wrap
            whole = out.render(feather=feather).pixels
            y0, y1 = (-height - 3, height + 2) if wrap.y else (height // 3, height)
            x0, x1 = (-5, 2 * width) if wrap.x else (0, width - width // 2)
            part = out.render(feather=feather, box=Box(y0, x0, y1, x1)).pixels
            crop = whole[np.ix_(np.arange(y0, y1) % height, np.arange(x0, x1) % width)]
            assert part.tobytes() == np.ascontiguousarray(crop).tobytes()

        self.for_all(law)

    @pytest.mark.parametrize("corner", [(0, 0), (-7, 3), (2**40 - 5, -(2**40))])
    def test_a_computed_window_is_a_crop(self, corner: tuple[int, int]) -> None:
        """Law 5 of window methods: a window's map, computed alone, equals that window of any larger one."""
        self.claims(Ability.WINDOW)
        y, x = corner

        def law(case: Case) -> None:
            small = self.map_of_window(case, Box(y + 4, x + 6, y + 20, x + 31))
            large = self.map_of_window(case, Box(y, x, y + 40, x + 33))
            assert same_map(small, large.window(Box(4, 6, 20, 31)))

        self.for_all(law)

    def test_the_wrapped_border_is_no_worse_than_the_inside(self) -> None:
        """Law 6: neighbours across a wrapped border differ no more than those along the worst joins inside."""
        self.claims(Ability.WRAP)
        across = np.zeros(4)
        for seed in range(6):
            e = Exemplar.of(texture(36, 32, 1, seed))
            out = synthesize(e, (48, 54), self.method, seed=seed, wrap=Wrap.BOTH, run=Run(threads=1))
            pixels = out.render(feather=0).pixels.astype(float)[:, :, 0]
            for axis in (0, 1):
                steps = np.abs(np.roll(pixels, -1, axis) - pixels).mean(axis=1 - axis)
                across[axis] += steps[-1]
                across[2 + axis] += steps[:-1].max()
        assert across[0] <= 1.1 * across[2]
        assert across[1] <= 1.1 * across[3]

    def test_inputs_are_never_written_to(self) -> None:
        """Law 8: arrays given stay as they are, and may be read-only, of any order and any strides."""
        pixels = np.asfortranarray(texture(29, 50, 3, 1))[:, ::-2]
        before = pixels.copy()
        pixels.flags.writeable = False
        out = synthesize(pixels, (33, 40), self.method, run=Run(threads=1))
        first = out.render().pixels.copy()
        assert (pixels == before).all()
        assert not np.shares_memory(out.render().pixels, pixels)
        assert (synthesize(np.ascontiguousarray(pixels), (33, 40), self.method).render().pixels == first).all()
        if Ability.START in self.method.supports:
            start = self._start(Case(out.exemplars, (33, 40), 0, Wrap.NONE), "middle")
            digest = start.digest
            synthesize(pixels, None, self.method, start=start, run=Run(threads=1))
            assert start.digest == digest

    def test_planes_rendered_together_or_alone_agree(self) -> None:
        """Law 9: one map draws all planes, in any order; each is that of its exemplar."""
        planes = {"albedo": texture(28, 26, 3, 2), "height": texture(28, 26, 1, 3)[:, :, 0], "normal": texture(28, 26, 3, 4)}
        out = synthesize(planes, (31, 39), self.method, run=Run(threads=1))
        again = synthesize(planes, (31, 39), self.method, run=Run(threads=1))
        for feather in (0, 3):
            forth = {n: out.render(n, feather=feather).pixels.tobytes() for n in planes}
            back = {n: again.render(n, feather=feather).pixels.tobytes() for n in reversed(planes)}
            assert forth == back
        for name in ("albedo", "height"):
            assert (out.render(name, feather=0).pixels == looked_up(out.exemplars, out.map, name)).all()

    def test_saved_maps_and_recipes_reproduce(self, tmp_path: Path) -> None:
        """Law 10: a saved map renders the same, and the recipe alone gives the same map."""

        def law(case: Case) -> None:
            out = case.grow(self.method)
            out.map.save(tmp_path / "map.npz")
            loaded = replace(out, map=SourceMap.load(tmp_path / "map.npz"))
            assert same_map(loaded.map, out.map)
            assert (loaded.map.sources, loaded.map.wrap, loaded.map.blend) == (out.map.sources, out.map.wrap, out.map.blend)
            assert loaded.render(feather=2).pixels.tobytes() == out.render(feather=2).pixels.tobytes()
            again = replayed(out.recipe_text, case.exemplars)
            assert same_map(again.map, out.map)
            assert again.recipe == out.recipe

        self.for_all(law)

    def test_cancelling_stops_at_every_step(self) -> None:
        """Law 12: set at any step, the event ends the work with CancelledError; drafts are maps with holes or none."""
        e = Exemplar.of(texture(26, 24, 3, 7))
        ticks: list[tuple[int, int]] = []
        synthesize(e, (40, 44), self.method, run=Run(1, lambda done, total, draft: ticks.append((done, total))))
        assert ticks
        assert [d for d, _ in ticks] == sorted(d for d, _ in ticks)
        assert all(0 <= d <= total for d, total in ticks)
        for stop in {0, len(ticks) // 2, len(ticks) - 1}:
            event, seen = threading.Event(), []

            def step(done: int, total: int, draft: Any, at: int = stop, cancel: Any = event, s: Any = seen) -> None:
                if draft is not None:
                    assert (draft().height, draft().width) == (40, 44)
                s.append(done)
                if len(s) > at:
                    cancel.set()

            with pytest.raises(CancelledError):
                synthesize(e, (40, 44), self.method, run=Run(1, step, event))
            assert len(seen) == stop + 1

    def test_the_depth_of_the_pixels_changes_no_map(self) -> None:
        """Law 13: 8 bits, the same times 257 in 16 bits, and over 255 in floats give the same map."""

        def law(case: Case) -> None:
            pixels = [texture(e.height, e.width, e.base.channels, n) for n, e in enumerate(case.exemplars)]
            maps = []
            for dtype in ("uint8", "uint16", "float32", "float64"):
                deep = [Plane(as_depth(p, dtype), Kind.COLOUR, Transfer.SRGB) for p in pixels]
                given = [Exemplar.of(p, usable=e.usable, toroidal=e.toroidal) for p, e in zip(deep, case.exemplars, strict=True)]
                maps.append(replace(case, exemplars=tuple(given)).grow(self.method).map)
            assert len({m.digest for m in maps}) == 1

        self.for_all(law)

    @pytest.mark.parametrize("ability", list(Ability))
    def test_what_is_not_claimed_is_refused(self, ability: Ability) -> None:
        """An ability that is not claimed is refused with one line before any work."""
        if ability is Ability.WINDOW:
            pytest.skip("nothing can ask for a window yet")
        if ability in self.method.supports:
            pytest.skip("it is claimed")
        e = Exemplar.of(texture(24, 22, 3, 8))
        label = Plane(np.zeros((24, 22), np.uint8), Kind.LABEL)
        asked: dict[Ability, Callable[[], object]] = {
            Ability.WRAP: lambda: synthesize(e, 30, self.method, wrap="x"),
            Ability.START: lambda: synthesize(e, None, self.method, start=identity([e.source], 0)),
            Ability.MASK: lambda: synthesize(replace(e, usable=np.arange(22) > np.zeros((24, 1)), _memo={}), 30, self.method),
            Ability.GUIDE: lambda: synthesize(e, (24, 22), self.method, guide=Guide(label, label)),
            Ability.SEVERAL: lambda: synthesize([e, e], 30, self.method),
            Ability.ISOMETRIES: lambda: make(self.method.slug, {"isometries": "both"}),
        }
        with pytest.raises(ParameterError) as caught:
            asked[ability]()
        assert "\n" not in str(caught.value)
