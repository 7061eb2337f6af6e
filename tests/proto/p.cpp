#include <cstdio>
#include <random>
#include <functional>
#include <Eigen/Geometry>
#include "quench/shape.h"
#include "quench/surface.h"
#include "closed_surfaces.h"
using namespace quench;
int main(int argc,char**argv){
  for (int shape=0;shape<2;++shape)
  for (double radius: {3.,4.,6.,10.}) for (double width: {1.,2.,3.}) for (double noise: {0.,.05}) {
    if (noise>0 && width==1 && false) continue;
    double sm=0, ss=0, smin=0, sv=0; double wmin=0; int reps=noise>0?6:6; int cnt=0; double sr=0,nr=0;
    for(int rep=0;rep<reps;++rep){
      std::mt19937 random(rep+1); std::normal_distribution<double> gauss(0,1); std::uniform_real_distribution<double> u(0,1);
      int side = int(2*radius+10); int len = shape? 40: side;
      Vec3 c(side/2.+u(random)-.5, side/2.+u(random)-.5, len/2.+u(random)-.5);
      Vec3 ax(.2*u(random),.2*u(random),1); ax.normalize();
      auto dist=[&](const Vec3&p){ Vec3 d=p-c; if(shape) d-=d.dot(ax)*ax; return radius-d.norm();};
      Volume v; v.grid.dims={side,side,len}; std::vector<float> s;
      for(int z=0;z<len;++z)for(int y=0;y<side;++y)for(int x=0;x<side;++x) s.push_back(float(0.5+0.5*std::erf(dist(Vec3(x,y,z))*std::sqrt(M_PI)/width)+(noise>0?noise*gauss(random):0)));
      v.samples=std::move(s);
      ForegroundOptions o; o.threshold=0.5; o.largest_component=true; o.fill_cavities=true; std::optional<TriangleMesh> m;
      foreground(v,o,nullptr,nullptr,&m);
      if(getenv("SM")) smooth_surface(*m);
      double sum=0,sq=0; size_t n=0;
      for(auto&t:m->triangles){ Vec3 q=(m->points[t[0]]+m->points[t[1]]+m->points[t[2]])/3-Vec3::Constant(.5); if(shape && std::abs((q-c).dot(ax))>12) continue; double e=-dist(q); sum+=e; sq+=e*e; ++n;}
      sum/=n; sm+=sum; ss+=std::sqrt(sq/n-sum*sum);
      Surface S(*m, SurfaceKind::grey);
      // inscribed radius along the axis, centre optimised by tiny search
      for(int k=-5;k<=5;++k){ if(!shape&&k) continue; Vec3 p=c+Vec3::Constant(.5)+ax*k; double best=S.nearest(p).distance; sr+=best-radius; nr+=1;
        double step=.1; double opt=best; Vec3 q=p; for(int it=0;it<40;++it){ bool f=false; for(int d=0;d<6;++d){ Vec3 t=q; t[d/2]+=d%2?step:-step; if(shape) t-= (t-p).dot(ax)*ax; double r=S.nearest(t).distance; if(r>opt){opt=r;q=t;f=true;} } if(!f) step/=2; if(step<1e-3)break;}
        smin+=opt-radius; ++cnt; wmin=std::max(wmin,std::abs(opt-radius)); }
    }
    std::printf("%s R %2.0f width %.0f noise %.2f: face mean %+.4f sd %.4f | at axis %+.4f | inscribed mean %+.4f worst %.4f\n", shape?"tube":"ball",radius,width,noise,sm/reps,ss/reps,sr/nr,smin/cnt,wmin);
  }
}
