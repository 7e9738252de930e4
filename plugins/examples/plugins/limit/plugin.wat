;; `limit`: keeps curves between two bounds. WebAssembly as it is written by hand, to show how little the interface asks for:
;; two functions, memory, and records whose fields lie one after the other, each at a multiple of its size.
(module
  (memory (export "memory") 1)
  ;; Texts, one after the other.
  (data (i32.const 16) "limit")
  (data (i32.const 21) "Keeps every value of the curves between two bounds.")
  (data (i32.const 72) "curves")
  (data (i32.const 78) "Curves")
  (data (i32.const 84) "one value per channel and frame")
  (data (i32.const 115) "the same, none beyond the bounds")
  (data (i32.const 147) "least")
  (data (i32.const 152) "No value is below.")
  (data (i32.const 170) "most")
  (data (i32.const 174) "No value is above.")
  (data (i32.const 192) "it is below `least`; no value could be between them")
  ;; Schemas and answers are put together from 512 on; what the host brings, lies from 4096 on.
  (global $end (mut i32) (i32.const 4096))

  ;; Memory for the host to put values in. A plugin lives for one evaluation: nothing is freed.
  (func $realloc (export "cabi_realloc") (param $old i32) (param $old_size i32) (param $align i32) (param $size i32) (result i32)
    (local $start i32)
    (local.set $start
      (i32.and
        (i32.add (global.get $end) (i32.sub (local.get $align) (i32.const 1)))
        (i32.sub (i32.const 0) (local.get $align))))
    (global.set $end (i32.add (local.get $start) (local.get $size)))
    (block $enough
      (br_if $enough (i32.le_u (global.get $end) (i32.shl (memory.size) (i32.const 16))))
      (br_if $enough
        (i32.ne
          (memory.grow
            (i32.shr_u
              (i32.add (i32.sub (global.get $end) (i32.shl (memory.size) (i32.const 16))) (i32.const 65535))
              (i32.const 16)))
          (i32.const -1)))
      unreachable)
    (memory.copy (local.get $start) (local.get $old) (local.get $old_size))
    (local.get $start))

  ;; A text or a list: where it lies, and how long it is.
  (func $pair (param $at i32) (param $where i32) (param $length i32)
    (i32.store (local.get $at) (local.get $where))
    (i32.store offset=4 (local.get $at) (local.get $length)))

  ;; A parameter's default (a number) and its range.
  (func $number (param $at i32) (param $default f64)
    (i32.store8 offset=16 (local.get $at) (i32.const 2))
    (f64.store offset=24 (local.get $at) (local.get $default))
    (i32.store8 offset=32 (local.get $at) (i32.const 1))
    (f64.store offset=40 (local.get $at) (f64.const -1e6))
    (i32.store8 offset=48 (local.get $at) (i32.const 1))
    (f64.store offset=56 (local.get $at) (f64.const 1e6)))

  ;; list<node-schema>: one of 56 bytes at 520, its ports of 28 at 600 and 640, its parameters of 72 at 704.
  (func $describe (export "grimace:node/nodes@0.1.0#describe") (result i32)
    (call $pair (i32.const 512) (i32.const 520) (i32.const 1))
    (call $pair (i32.const 520) (i32.const 16) (i32.const 5)) ;; name
    (call $pair (i32.const 528) (i32.const 21) (i32.const 51)) ;; doc
    (i32.store (i32.const 536) (i32.const 1)) ;; version
    (i32.store8 (i32.const 540) (i32.const 1)) ;; per frame
    (i32.store (i32.const 544) (i32.const 0)) ;; with no others
    (call $pair (i32.const 552) (i32.const 600) (i32.const 1)) ;; inputs
    (call $pair (i32.const 560) (i32.const 640) (i32.const 1)) ;; outputs
    (call $pair (i32.const 568) (i32.const 704) (i32.const 2)) ;; parameters
    (call $pair (i32.const 600) (i32.const 72) (i32.const 6))
    (call $pair (i32.const 608) (i32.const 78) (i32.const 6))
    (call $pair (i32.const 616) (i32.const 84) (i32.const 31))
    (call $pair (i32.const 640) (i32.const 72) (i32.const 6))
    (call $pair (i32.const 648) (i32.const 78) (i32.const 6))
    (call $pair (i32.const 656) (i32.const 115) (i32.const 32))
    (call $pair (i32.const 704) (i32.const 147) (i32.const 5))
    (call $pair (i32.const 712) (i32.const 152) (i32.const 18))
    (call $number (i32.const 704) (f64.const 0))
    (call $pair (i32.const 776) (i32.const 170) (i32.const 4))
    (call $pair (i32.const 784) (i32.const 174) (i32.const 18))
    (call $number (i32.const 776) (f64.const 1))
    (i32.const 512))

  ;; Parameters come in the order of their names: `least` is the first, `most` the second, 24 bytes each with the number at
  ;; 16. There is one input: a standing of 16 bytes, whose list of items is at 8; its item has the value at 8, with its kind
  ;; there and the curves at 16: frames (24 bytes), channels at 40, values at 48.
  (func $evaluate (export "grimace:node/nodes@0.1.0#evaluate")
    (param $node i32) (param $node_length i32) (param $parameters i32) (param $parameter_count i32)
    (param $inputs i32) (param $input_count i32) (result i32)
    (local $least f32) (local $most f32) (local $item i32) (local $at i32) (local $last i32)
    (local.set $least (f32.demote_f64 (f64.load offset=16 (local.get $parameters))))
    (local.set $most (f32.demote_f64 (f64.load offset=40 (local.get $parameters))))
    (if (f32.lt (local.get $most) (local.get $least))
      (then ;; result: an error at 900; its fault at 904: a parameter, its name and the problem
        (i32.store8 (i32.const 900) (i32.const 1))
        (i32.store8 (i32.const 904) (i32.const 1))
        (call $pair (i32.const 908) (i32.const 170) (i32.const 4))
        (call $pair (i32.const 916) (i32.const 192) (i32.const 51))
        (return (i32.const 900))))
    (local.set $item (i32.load offset=8 (local.get $inputs)))
    (local.set $at (i32.load offset=48 (local.get $item)))
    (local.set $last (i32.add (local.get $at) (i32.shl (i32.load offset=52 (local.get $item)) (i32.const 2))))
    (block $done
      (loop $next
        (br_if $done (i32.ge_u (local.get $at) (local.get $last)))
        (f32.store (local.get $at) (f32.min (f32.max (f32.load (local.get $at)) (local.get $least)) (local.get $most)))
        (local.set $at (i32.add (local.get $at) (i32.const 4)))
        (br $next)))
    ;; What came in goes out: one standing at 912 with the item that the host brought.
    (i32.store8 (i32.const 900) (i32.const 0))
    (call $pair (i32.const 904) (i32.const 912) (i32.const 1))
    (call $pair (i32.const 912) (i32.const 72) (i32.const 6))
    (call $pair (i32.const 920) (local.get $item) (i32.const 1))
    (i32.const 900)))
