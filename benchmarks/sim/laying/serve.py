import sys; sys.path.insert(0,'/tmp/lay')
from trial import *
def prepare(cell, wid, first=WireEnd.A, steps=('lay','b')):
    wire=cell.plant.panel.wire(wid)
    ins, hold = cell.contexts['robot_1'], cell.contexts['robot_2']
    cell.feed(wid, '')
    do(cell, detect_cable, goals.DetectGoal(wid))
    tA = wire.goes_to(first); tB = wire.goes_to(first.other)
    sA = do(cell, locate_gearbox_component, goals.LocateGoal(*tA)).socket_pose
    sB = do(cell, locate_gearbox_component, goals.LocateGoal(*tB)).socket_pose
    t=time.time()
    cell.run(pick_end(hold, first.other, 0.0, sB, shares=(0,1)), 'robot_2')
    cell.run(pick_end(ins, first, 0.0, sA, shares=(0,1)), 'robot_1')
    snap(cell, f'{wid}_picked')
    print(f'   picked both [{time.time()-t:.1f}s]', flush=True)
    gripinfo(cell, ins); gripinfo(cell,hold)
    import remodel_sim.abilities.insert_cable as IC
    if not hasattr(IC,'_o'):
        IC._o=IC.push_in
        def wrapped(context,*a,**k):
            print('    before push'); gripinfo(cell,context); tipinfo(cell,context.wire.id,context.belief.grip.end); c=context.tool; look_at(cell,f'{context.wire.id}_push{context.belief.grip.end.value}',(c.x,c.y,c.z),(c.x+.5,c.y-.7,c.z+.4),fov=45)
            return (yield from IC._o(context,*a,**k))
        IC.push_in=wrapped
    do(cell, insert_cable, goals.InsertGoal('robot_1', wid, first, *tA, sA, 8.0))
    snap(cell, f'{wid}_a')
    do(cell, fix_cable, goals.FixGoal('robot_1', wid, *tA, 5.0))
    snap(cell, f'{wid}_fixed'); gripinfo(cell,hold)
    return wire, ins, hold, first, tA, tB, sA, sB

def finish(cell, wire, ins, hold, first, tA, tB, sA, sB):
    wid=wire.id
    import importlib, remodel_sim.abilities.primitives.holding as H, remodel_sim.abilities.primitives.together as T, remodel_sim.abilities.primitives.route_check as RC, remodel_sim.abilities.primitives.pushing as P, remodel_sim.abilities.insert_cable as IC0
    import remodel_sim.abilities.lay_wire as LW
    import remodel_sim.abilities.primitives.motions as MO
    for m in (T,H,RC,P,IC0,LW): importlib.reload(m)
    lay_wire=LW.lay_wire; insert_cable=IC0.insert_cable
    LW._b=LW._bring
    def wb(holder, guide, place, turn, left, free):
        t0=cell.plant.now if hasattr(cell.plant,'now') else 0
        r=(yield from LW._b(holder,guide,place,turn,left,free))
        print('    led to', np.round(place.at*1e3), round(math.degrees(place.yaw)), 'left', round(left,3), 'straight', round(float(np.linalg.norm(holder.tool.position-place.at)),3), 'peak', round(r,1), 'holder', holder.commanded, f'{time.time()-t:.0f}s', flush=True)
        return r
    LW._bring=wb
    t=time.time()
    r = cell.run(lay_wire(hold, ins, LayGoal('robot_2','robot_1',wid)), 'robot_1','robot_2')
    print('   ', r, f'[{time.time()-t:.1f}s]')
    snap(cell, f'{wid}_laid'); snap(cell, f'{wid}_laid_o','overhead')
    print('    in ducts', in_ducts(cell, wire)); gripinfo(cell,hold)
    cv2.imwrite(f'{wid}_judged.png', 0*np.zeros((2,2))) if False else None
    do(cell, insert_cable, goals.InsertGoal('robot_2', wid, first.other, *tB, sB, 8.0), 'robot_2')
    do(cell, fix_cable, goals.FixGoal('robot_2', wid, *tB, 5.0), 'robot_2')
    print('    in ducts', in_ducts(cell, wire) )
    snap(cell, f'{wid}_done'); snap(cell, f'{wid}_done_o','overhead')
    print(ground_truth(cell.plant,[wid]))

def serve(wid):
    panel = read_panel(CONFIG/'household.yaml', read_wire_materials())
    cell = Cell(panel, design=read_cell('two_arms_cabinet'), seed=int(os.environ.get('SEED','1')))
    args=prepare(cell, wid)
    print('READY', flush=True)
    trig=f'/tmp/lay/trigger_{wid}'
    while True:
        if os.path.exists(trig):
            log=open(trig).read().strip(); os.remove(trig)
            if log=='quit': return
            pid=os.fork()
            if pid==0:
                f=open(log,'w'); os.dup2(f.fileno(),1); os.dup2(f.fileno(),2)
                try: finish(cell,*args)
                except AbilityError as error:
                    print('!!',error.code.name,error)
                    for e2 in WireEnd: tipinfo(cell, wid, e2)
                    n=cell.plant.live.cable.nodes(); print([tuple(int(v) for v in np.round(p*1e3)) for p in n])
                    c=cell.contexts['robot_1'].tool; look_at(cell, f'{wid}_close', (c.x,c.y,c.z), (c.x+0.25,c.y-0.35,c.z+0.25)); snap(cell, f'{wid}_failed'); snap(cell, f'{wid}_failed_o','overhead')
                except BaseException: traceback.print_exc()
                print('END',flush=True); os._exit(0)
            os.waitpid(pid,0)
        time.sleep(0.5)
if __name__=='__main__': serve(sys.argv[1])
