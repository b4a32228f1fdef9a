#!/usr/bin/env python3
"""Positions of Khronos' BoxAnimated and Fox in an animation, by a straight reading of the specification:
the numbers in tests/test_gltf.c.   reference.py FOLDER_OF_SAMPLES"""
import json,struct,math,sys
def load(p):
    d=open(p,'rb').read(); n=struct.unpack('<I',d[12:16])[0]; j=json.loads(d[20:20+n]); b=d[20+n+8:]
    return j,b
def acc(j,b,i):
    a=j['accessors'][i]; v=j['bufferViews'][a['bufferView']]; n={'SCALAR':1,'VEC2':2,'VEC3':3,'VEC4':4,'MAT4':16}[a['type']]
    c={5120:'b',5121:'B',5122:'h',5123:'H',5125:'I',5126:'f'}[a['componentType']]; s=struct.calcsize(c)
    st=v.get('byteStride',n*s); o=v.get('byteOffset',0)+a.get('byteOffset',0)
    return [struct.unpack_from('<%d%s'%(n,c),b,o+k*st) for k in range(a['count'])]
def quat(q):
    x,y,z,w=q
    return [[1-2*(y*y+z*z),2*(x*y-z*w),2*(x*z+y*w)],[2*(x*y+z*w),1-2*(x*x+z*z),2*(y*z-x*w)],[2*(x*z-y*w),2*(y*z+x*w),1-2*(x*x+y*y)]]
def trs(t,q,s):
    r=quat(q); return [[r[i][k]*s[k] for k in range(3)]+[t[i]] for i in range(3)]+[[0,0,0,1]]
def mul(a,b): return [[sum(a[i][k]*b[k][c] for k in range(4)) for c in range(4)] for i in range(4)]
def ev(times,vals,t,rot,interp):
    times=[x[0] for x in times]
    if t<=times[0]: return vals[0]
    if t>=times[-1]: return vals[-1]
    i=max(k for k in range(len(times)) if times[k]<=t); u=(t-times[i])/(times[i+1]-times[i])
    assert interp=='LINEAR'
    a,b=vals[i],vals[i+1]
    if rot:
        d=sum(x*y for x,y in zip(a,b)); sg=1
        if d<0: d=-d; sg=-1
        th=math.acos(min(d,1))
        if th<1e-5: return [x+(sg*y-x)*u for x,y in zip(a,b)]
        return [(math.sin((1-u)*th)*x+sg*math.sin(u*th)*y)/math.sin(th) for x,y in zip(a,b)]
    return [x+(y-x)*u for x,y in zip(a,b)]
def worlds(j,b,an,t):
    n=[dict(t=x.get('translation',[0,0,0]),q=x.get('rotation',[0,0,0,1]),s=x.get('scale',[1,1,1]),m=x.get('matrix')) for x in j['nodes']]
    A=j['animations'][an]
    for c in A['channels']:
        s=A['samplers'][c['sampler']]; p=c['target']['path']
        n[c['target']['node']][{'translation':'t','rotation':'q','scale':'s'}[p]]=ev(acc(j,b,s['input']),acc(j,b,s['output']),t,p=='rotation',s.get('interpolation','LINEAR'))
    par={}
    for i,x in enumerate(j['nodes']):
        for c in x.get('children',[]): par[c]=i
    def loc(i):
        if n[i]['m']: return [[n[i]['m'][4*c+r] for c in range(4)] for r in range(4)]
        return trs(n[i]['t'],n[i]['q'],n[i]['s'])
    def w(i): return mul(w(par[i]),loc(i)) if i in par else loc(i)
    return w
M=sys.argv[1]+'/'
j,b=load(M+'BoxAnimated/glTF-Binary/BoxAnimated.glb')
for f in (30,60):
    w=worlds(j,b,0,(f-1)/24)
    for i,x in enumerate(j['nodes']):
        if 'mesh' in x: print('box',f,i,[['%.6f'%v for v in r] for r in w(i)[:3]])
j,b=load(M+'Fox/glTF-Binary/Fox.glb')
w=worlds(j,b,2,(6-1)/24); sk=j['skins'][0]; ib=acc(j,b,sk['inverseBindMatrices'])
pr=j['meshes'][0]['primitives'][0]; P=acc(j,b,pr['attributes']['POSITION']);J=acc(j,b,pr['attributes']['JOINTS_0']);W=acc(j,b,pr['attributes']['WEIGHTS_0'])
mats=[mul(w(n),[[ib[k][4*c+r] for c in range(4)] for r in range(4)]) for k,n in enumerate(sk['joints'])]
for v in (0,100,500,1500):
    p=[0,0,0]
    for k in range(4):
        q=[sum(mats[J[v][k]][r][c]*(list(P[v])+[1])[c] for c in range(4)) for r in range(3)]
        p=[a+W[v][k]*c for a,c in zip(p,q)]
    print('fox',v,['%.5f'%x for x in p])
